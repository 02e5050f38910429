(nc-no-end)
%
O1
G21 G0 X0.
M98 P2
M30
O2
G0 X1.
O3
G0 X2.
M99
%
