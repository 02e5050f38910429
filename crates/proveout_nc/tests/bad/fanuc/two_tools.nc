(nc-conflicting-words)
T1 T2
M30
