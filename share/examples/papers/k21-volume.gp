set logscale y
set format y '10^{%T}'
set xlabel 'angle of the joint, degrees'
set ylabel 'size of the volume error, of the rest volume'
plot data using 2:(abs($3 - 1)) skip 2 with linespoints ls 1 title 'kohout, as published', \
     data using 2:(abs($4 - 1)) skip 2 with linespoints ls 2 title 'guarded, as many iterations', \
     data using 2:(abs($5 - 1)) skip 2 with linespoints ls 3 title 'default', \
     0.01 with lines ls 4 title 'published: below 1 %'
