; nc-unsupported-word
BEGIN PGM BAD MM
TOOL CALL 1 Z S100
X+10 R+ F100
