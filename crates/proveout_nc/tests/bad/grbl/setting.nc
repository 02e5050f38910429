(nc-unsupported-word)
G21 G90
$32=1
G0 X1
M2
