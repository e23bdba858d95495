# What sensors read (lines, left axis), their thresholds (dashed) and the activations that they give (filled, right axis), a panel each.
# After the sensors, channels: activations alone. Usage: gnuplot -c motion-sense.gp DATA CHART TITLE PANELS SENSORS
#   DATA    a block for each panel: its quoted title, then lines of time, reading, activation and threshold, NaN where there is none
#   CHART   .svg or .png
data = ARG1; panels = int(ARG4); sensors = int(ARG5)
columns = panels > 12 ? 3 : panels > 4 ? 2 : 1
rows = (panels + columns - 1) / columns
width = 480 * columns + (columns == 1 ? 320 : 0); height = 190 * rows + 50

set encoding utf8
if (ARG2[strlen(ARG2)-3:] eq ".svg") {
    set terminal svg size width,height font "Helvetica,12" background "#ffffff"
} else {
    set terminal pngcairo size width,height font "Helvetica,9.5" background "#ffffff"
}
set output ARG2
set datafile separator "\t"
set datafile missing NaN
set border 11 lc rgb "#666666"
set tics nomirror
set y2range [0:1.05]
set y2tics 0.5 textcolor rgb "#c1432e"
set grid xtics ytics lt 1 lc rgb "#dddddd" lw 0.6
set xlabel "time, s" offset 0,0.6
set style fill solid 0.22 noborder
set autoscale xfix
set key tmargin left Left reverse samplen 1.2 noenhanced
set multiplot layout rows,columns title ARG3 noenhanced
do for [i = 0:panels-1] {
    if (i < sensors) {
        plot data index i using 1:3 axes x1y2 with filledcurves y=0 lc rgb "#c1432e" notitle, \
             data index i using 1:3 axes x1y2 with lines lw 1.2 lc rgb "#c1432e" notitle, \
             data index i using 1:4 with lines dt 2 lw 1.0 lc rgb "#666666" notitle, \
             data index i using 1:2 with lines lw 1.6 lc rgb "#1b6ca8" title columnheader(1)
    } else {
        set yrange [0:1.05]
        plot data index i using 1:3 with filledcurves y=0 lc rgb "#c1432e" notitle, \
             data index i using 1:3 with lines lw 1.6 lc rgb "#c1432e" title columnheader(1)
    }
}
unset multiplot
unset output
