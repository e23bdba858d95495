# Moment arms of the muscles over the angle, a panel each: mean of the fibres in each sweep, band from least to greatest in the first. Called by
# sweep.sh with data, picture, kind, muscles.
n = words(muscles)
columns = n < 3 ? n : n < 7 ? 3 : 4
rows = int((n + columns - 1) / columns)
if (kind eq 'svg') set terminal svg size 300*columns,260*rows font 'sans,12' background '#ffffff'; else set terminal pngcairo size 300*columns,260*rows font 'sans,10'
set output picture
set datafile separator tab
set termoption noenhanced
set multiplot layout rows,columns
set grid lc rgb '#d8d8d8'
set border 3
set tics nomirror out
set key top left samplen 1
set xlabel 'angle, degrees'
set ylabel 'moment arm, mm'
do for [k=1:n] {
    m = word(muscles, k)
    set title m
    plot data using (strcol(1) eq m && $2 == 1 ? $3 : NaN):5:6 with filledcurves fc rgb '#fbe3da' notitle, \
         data using (strcol(1) eq m && $2 == 1 ? $3 : NaN):4 with lines lc rgb '#b5332b' lw 2 title (k == 1 ? 'there' : ''), \
         data using (strcol(1) eq m && $2 == 2 ? $3 : NaN):4 with lines lc rgb '#2a6bb0' lw 1.5 dt 2 title (k == 1 ? 'back' : '')
}
unset multiplot
