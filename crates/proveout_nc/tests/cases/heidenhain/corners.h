0 BEGIN PGM CORNERS MM
1 TOOL CALL 1 Z S1000 F500
2 L X+0 Y+0 Z+0 R0 FMAX
3 L X+50 RL F300
4 RND R10 F100
FUNCTION MODE MILL
; a note between the elements comes behind the corner
; feet (40, 0) and (50, 10), center (40, 10); the feed holds for the arc alone
5 L Y+40
6 CHF 5
; (50, 35) to (45, 40)
7 L X+20
8 RND R5
9 CC X+0 Y+40
10 C X-20 Y+40 DR-
; Line y = 40 along -x, then the circle of radius 20 about (0, 40), clockwise from (20, 40), which begins along -y: a left turn.
; The center lies 5 below the line, y = 35, and at 15 from (0, 40) on the inner side: the clockwise circle moved to its left
; grows to 25: x = sqrt(625 - 25) = 24.494897. Feet (24.494897, 40) and (0, 40) + 20/25 (24.494897, -5) = (19.595918, 36).
11 RND R4
12 L X-60
; The circle ends at (-20, 40) along +y, the line goes along -x: a left turn. Line moved left: y = 36. Circle moved left: 24.
; x = -sqrt(576 - 16) = -23.664319; feet (-19.720266, 36.666667) on the circle, (-23.664319, 40) on the line.
13 M30
12 END PGM CORNERS MM
