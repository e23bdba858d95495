# [K21] table 2
$published << END
10622	57.12
13858	47.21
17124	35.89
19752	33.85
END
set logscale y
set xlabel 'triangles'
set ylabel 'steps a second'
set xrange [0:*]
plot $published using 1:2 with linespoints ls 4 title 'published', \
     data using 2:3 skip 1 with points ls 1 ps 1.4 title 'kohout', \
     data using 2:4 skip 1 with points ls 3 ps 1.4 title 'the default, qn'
