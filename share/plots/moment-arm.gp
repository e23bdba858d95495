# Moment arms over a coordinate, a panel a muscle: the envelope of the fibres (filled), their mean, the ways up and down (thin), and what was
# measured (points with bars). Usage: gnuplot -c moment-arm.gp DATA CHART TITLE PANELS XLABEL YLABEL
#   DATA    two blocks for each panel: its quoted title, then lines of coordinate, mean, least, greatest, up, down; then "measured" and lines of
#           coordinate, arm, lower, upper; NaN where there is none
#   CHART   .svg or .png
data = ARG1; panels = int(ARG4)
columns = panels > 12 ? 4 : panels > 4 ? 3 : panels > 1 ? 2 : 1
rows = (panels + columns - 1) / columns
width = 420 * columns + (columns == 1 ? 280 : 0); height = 270 * rows + 60 + (rows == 1 ? 120 : 0)

set encoding utf8
if (ARG2[strlen(ARG2)-3:] eq ".svg") {
    set terminal svg size width,height font "Helvetica,12" background "#ffffff"
} else {
    set terminal pngcairo size width,height font "Helvetica,9.5" background "#ffffff"
}
set output ARG2
set datafile separator "\t"
set datafile missing NaN
set border 3 lc rgb "#666666"
set tics nomirror
set grid xtics ytics lt 1 lc rgb "#dddddd" lw 0.6
set xlabel ARG5 noenhanced offset 0,0.4
set ylabel ARG6 noenhanced offset 1,0
set style fill solid 0.22 noborder
set autoscale xfix
set xzeroaxis lt 1 lc rgb "#999999" lw 0.8
set key tmargin left Left reverse horizontal samplen 1.6 noenhanced
set multiplot layout rows,columns title ARG3 noenhanced
do for [i = 0:panels-1] {
    stats data index 2*i using 1 name "own" nooutput
    set xrange [own_min:own_max]
    stats data index 2*i+1 using (column(2) == column(2) ? 1 : 0) name "points" nooutput
    own_measured = points_max
    plot data index 2*i using 1:3:4 with filledcurves lc rgb "#1b6ca8" notitle, \
         data index 2*i+1 using 1:3:4 with filledcurves lc rgb "#c1432e" notitle, \
         data index 2*i using 1:5 with lines lw 1.0 dt 2 lc rgb "#2e8b57" title (i == 0 ? "up" : ""), \
         data index 2*i using 1:6 with lines lw 1.0 dt 3 lc rgb "#8b2e6b" title (i == 0 ? "down" : ""), \
         data index 2*i using 1:2 with lines lw 1.8 lc rgb "#1b6ca8" title columnheader(1), \
         data index 2*i+1 using 1:2 with points pt 7 ps 0.4 lc rgb "#c1432e" title (own_measured > 0 ? "measured" : "")
}
unset multiplot
unset output
