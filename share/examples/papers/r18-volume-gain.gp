set xlabel 'goal volume over rest volume'
set ylabel 'volume reached over rest volume'
set key left top inside vertical
plot x with lines ls 4 title 'goal', \
     data using 1:2 skip 2 with linespoints ls 1 title 'romeo, as published', \
     data using 1:4 skip 2 with linespoints ls 2 title 'guarded, the default'
