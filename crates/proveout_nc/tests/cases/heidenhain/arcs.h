0 BEGIN PGM ARCS MM
1 TOOL CALL 1 Z S1000 F500
2 L X+30 Y+0 Z+0 R0 FMAX
3 CC X+0 Y+0
4 C X+0 Y+30 DR+
; quarter about the origin, counter-clockwise
5 C X+0 Y+30 DR-
; end at start: a full circle, clockwise
6 CC IX+10 IY+0
; pole at (10, 30)
7 C X+20 Y+30 DR+
; half a turn from (0, 30)
8 CR X+20 Y+50 R+10 DR+
; R = half the chord: half a turn about (20, 40)
9 CR X+30 Y+40 R-10 DR-
; R below zero: three quarters; from (20, 50) clockwise to (30, 40) about (30, 50) or (20, 40): 270 degrees is about (30, 50)
10 L X+30 Y+30
11 CT X+40 Y+20
; leaves downwards, center (40, 30), quarter counter-clockwise
12 CC X+40 Y+0
13 LP PR+10 PA+90
; (40, 10)
14 LP IPR+5 IPA-90
; radius 15 at 0 degrees: (55, 0)
15 CP PA+180 DR+ IZ-2
; half a turn, Z -2
16 CP IPA-720 DR- IZ-10
; two turns down to Z -12, ends at (25, 0)
17 CC
; the pole at the position
18 LP PR+20 PA+0
19 CTP PR+20 PA+90
; the line before ran along +x; from (45, 0) to (25, 20) about (45, 20)... tangent +x: center (45, y), y from |c-(25,20)| = |y|: y = 20
20 M30
21 END PGM ARCS MM
