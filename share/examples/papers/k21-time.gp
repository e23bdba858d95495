# [K21] table 1: adductor brevis, 17124 triangles, i7-7700K
$published << END
1	53.04
3	62.55
5	74.66
10	104.96
25	193.66
50	441.72
100	658.71
END
set logscale xy
set xlabel 'iterations'
set ylabel 'time of a step, ms'
stats data using 2 skip 1 nooutput
least = STATS_min
last = int(STATS_blocks) - 1
plot $published using 1:2 with linespoints ls 4 title 'published, 17124 triangles', \
     for [k = 0:last] data using 2:3 skip (k == 0 ? 1 : 0) index k with linespoints ls 1 title (k == 0 ? 'kohout' : ''), \
     for [k = 0:last] data using 2:4 skip (k == 0 ? 1 : 0) index k with linespoints ls 2 title (k == 0 ? 'guarded' : ''), \
     for [k = 0:last] data using 2:5 skip (k == 0 ? 1 : 0) index k with linespoints ls 3 title (k == 0 ? 'the default, qn' : ''), \
     for [k = 0:last] data using 2:4:($2 == least ? strcol(1).' triangles' : '') skip (k == 0 ? 1 : 0) index k with labels left offset 0.8, 1.1 notitle
