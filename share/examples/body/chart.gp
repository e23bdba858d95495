# Activation, stiffness and volume of muscles over time. Given: table, picture, kind (svg or png).
if (kind eq 'svg') set terminal svg size 800,760 font 'sans,12' background '#ffffff'; else set terminal pngcairo size 800,760 font 'sans,11'
set output picture
set datafile separator tab
set datafile missing 'nan'
set border 3
set tics nomirror out
set grid ytics lc rgb '#d8d8d8'
set key outside below center horizontal noenhanced
stats table skip 1 nooutput
count = (STATS_columns - 1) / 3
set multiplot layout 3,1 margins 0.12,0.97,0.14,0.97 spacing 0,0.05
unset key
set ylabel 'activation'
set yrange [0:*]
plot for [k = 1:count] table skip 1 using 1:(column(3 * k - 1)) with lines lw 2
set ylabel 'stiffness, N/m'
set autoscale y
set logscale y
plot for [k = 1:count] table skip 1 using 1:(column(3 * k)) with lines lw 2
unset logscale y
set ylabel 'volume over rest'
set xlabel 'time, s'
set key outside below center horizontal noenhanced
plot for [k = 1:count] table skip 0 using 1:(column(3 * k + 1)) with lines lw 2 title columnheader(3 * k - 1)
unset multiplot
