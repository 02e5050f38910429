(nc-conflicting-words)
M3 M5 S100
