set logscale x
set xlabel 'iterations'
set ylabel 'mean length of edges over that at rest'
plot data using 2:3 skip 1 index 0 with linespoints ls 1 title 'kohout, along, off', \
     data using 2:5 skip 1 index 0 with linespoints ls 1 pt 6 dt 2 title 'on', \
     data using 2:4 skip 1 index 0 with linespoints ls 2 title 'across, off', \
     data using 2:6 skip 1 index 0 with linespoints ls 2 pt 4 dt 2 title 'on', \
     data using 2:3 index 1 with linespoints ls 3 title 'guarded, along, off', \
     data using 2:5 index 1 with linespoints ls 3 pt 8 dt 2 title 'on'
