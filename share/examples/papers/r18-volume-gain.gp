set logscale y
set format y '10^{%T}'
set xlabel 'goal volume over rest volume'
set ylabel 'distance from the goal, of the goal volume'
set xtics 0.1
set xrange [0.95:2.05]
plot data using 1:(abs($3)) skip 2 with linespoints ls 1 title 'romeo, as published', \
     data using 1:(abs($5)) skip 2 with linespoints ls 2 title 'guarded, the default scheme'
