(nc-not-run)
%
O1
G21 G0 X0.
M30
O2
G21 G0 X5.
M30
%
