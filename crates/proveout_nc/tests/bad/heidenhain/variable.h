; nc-unknown-variable
BEGIN PGM BAD MM
TOOL CALL 1 Z S100
L X+Q5 FMAX
