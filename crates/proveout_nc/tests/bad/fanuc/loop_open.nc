(nc-structure)
WHILE [#1 LT 3] DO 1
M30
