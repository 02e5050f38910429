(nc-unsupported-word)
G21 G90
$J=G91X1F100
G0 X1
M2
