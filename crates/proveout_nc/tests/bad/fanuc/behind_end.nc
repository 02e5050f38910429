(nc-not-run)
%
O1
G21 G90
G0 X0. Y0.
M30
G0 Z-60.
%
