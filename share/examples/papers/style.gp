# What all charts of the recipes have in common: the file and its kind come from chart() in common.sh.
if (kind eq 'svg') set terminal svg size 760,480 font 'sans,13' background '#ffffff'; else set terminal pngcairo size 760,480 font 'sans,11'
set output picture
set datafile separator tab
set datafile missing 'nan'
set key outside below center horizontal
set grid ytics lc rgb '#d8d8d8'
set border 3
set tics nomirror out
set style line 1 lc rgb '#b5332b' lw 2 pt 7 ps 0.7
set style line 2 lc rgb '#2a6bb0' lw 2 pt 5 ps 0.7
set style line 3 lc rgb '#3f9a4a' lw 2 pt 9 ps 0.7
set style line 4 lc rgb '#8a8a8a' lw 2 pt 6 ps 0.8 dt 2
