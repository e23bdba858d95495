set xlabel 'angle of the joint, degrees'
set ylabel 'volume over rest volume'
set format y '%.4f'
plot data using 2:3 skip 1 with linespoints ls 1 title 'kohout, as published', \
     data using 2:4 skip 1 with linespoints ls 2 title 'guarded, as many iterations', \
     data using 2:5 skip 1 with linespoints ls 3 title 'default', \
     1 with lines ls 4 notitle
