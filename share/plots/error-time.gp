# Error against run time on log axes: one line per solver family through its own front, every setting a point, the front of all marked.
# Usage: gnuplot -c error-time.gp DATA SVG PNG TITLE FLOOR FAMILIES SOLVER ERRORS
#   DATA      blocks of error-time.dat; FLOOR the reference's uncertainty; FAMILIES their number
#   SOLVER    1 = a second panel with the error against a converged solve of the same steps; ERRORS motion or equilibrium
data = ARG1; floor = real(ARG5); families = int(ARG6); solver = int(ARG7)

set encoding utf8
array colours[6] = ["#1b6ca8", "#c1432e", "#3a8a4d", "#8a5aa8", "#b8860b", "#555555"]
array marks[6] = [7, 5, 9, 11, 13, 3]

set logscale xy
set ytics 10
set format y "10^{%L}"
set format x "%g"
set xlabel "processor time of the run, s" offset 0,0.6
set grid xtics ytics lt 1 lc rgb "#cccccc" lw 0.6
set border 3 lc rgb "#666666"
set tics nomirror
set key below center horizontal Left reverse samplen 1.5 spacing 1.1 width 1

colour(i) = colours[1 + (i % 6)]
mark(i) = marks[1 + (i % 6)]

do for [output = 1:2] {
    if (output == 1) {
        set terminal svg size (solver ? 1100 : 640),520 font "Helvetica,13" background "#ffffff"
        set output ARG2
    } else {
        set terminal pngcairo size (solver ? 1100 : 640),520 font "Helvetica,10.5" background "#ffffff"
        set output ARG3
    }
    if (solver) { set multiplot layout 1,2 title ARG4 noenhanced } else { set title ARG4 noenhanced }
    set ylabel (ARG8 eq "motion" ? "total error: RMS / L, against h → 0" : "error: RMS / L, against the equilibrium")
    plot for [i = 0:families-1] data index 3*i using 1:2 with points pt mark(i) ps 0.55 lc rgb colour(i) notitle, \
         for [i = 0:families-1] data index 3*i+1 using 1:2 with linespoints pt mark(i) ps 0.9 lw 1.8 lc rgb colour(i) title columnheader(1) noenhanced, \
         data index 3*families using 1:2 with points pt 6 ps 2.0 lw 1.4 lc rgb "#222222" title columnheader(1), \
         data index 3*families+1 using 1:2 with points pt 2 ps 0.8 lc rgb "#999999" title columnheader(1), \
         floor with lines dt 2 lw 1.2 lc rgb "#999999" title sprintf("floor %.1e", floor)
    if (solver) {
        set ylabel "solver error: RMS / L, against the same steps solved"
        plot for [i = 0:families-1] data index 3*i using 1:3 with points pt mark(i) ps 0.55 lc rgb colour(i) notitle, \
             for [i = 0:families-1] data index 3*i+2 using 1:3 with linespoints pt mark(i) ps 0.9 lw 1.8 lc rgb colour(i) title columnheader(1) noenhanced
        unset multiplot
    }
    unset output
}
