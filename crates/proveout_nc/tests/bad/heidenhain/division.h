; nc-arithmetic
BEGIN PGM BAD MM
TOOL CALL 1 Z S100
Q1 = 1 / 0
