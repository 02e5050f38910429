; nc-conflicting-words
BEGIN PGM BAD MM
TOOL CALL 1 Z S100
L X+1 X+2 FMAX
