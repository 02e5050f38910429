(nc-no-end)
%
O1
G21 G90
G0 X0. Y0.
:20 T2 M6
G0 Z-60.
M30
%
