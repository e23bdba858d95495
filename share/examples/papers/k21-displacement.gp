set logscale xy
set format y '10^{%T}'
set xlabel 'iteration'
set ylabel 'mean displacement in the iteration, mm'
plot data using 1:4 with linespoints ls 1 title 'kohout, as published', \
     data using 1:5 with linespoints ls 2 title 'guarded, the scheme of xpbd', \
     0.1 with lines ls 4 title 'published: below 0.1 mm in a few, 0.01 mm in 10', 0.01 with lines ls 4 notitle
