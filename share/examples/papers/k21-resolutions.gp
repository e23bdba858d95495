set style data histograms
set style histogram clustered gap 1
set style fill solid 0.9 noborder
set logscale y
set yrange [0.1:*]
set key above
set bmargin 4
set ylabel 'time of a step, ms'
plot data using 4:xtic(sprintf("%s: %s\ntriangles,\n%s iterations", strcol(1), strcol(2), strcol(3))) skip 1 ls 1 title 'kohout, as published', \
     data using 7 skip 1 ls 2 title 'guarded, the scheme of xpbd', \
     data using 10 skip 1 ls 3 title 'the default, qn'
