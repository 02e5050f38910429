(nc-conflicting-words)
O1
M98 P20002
M30
O2
M99
O20002
M99
