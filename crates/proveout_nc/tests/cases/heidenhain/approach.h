0 BEGIN PGM APPROACH MM
1 TOOL CALL 1 Z S1000 F500
2 L X-50 Y-50 Z+10 R0 FMAX M3
3 APPR LT X+0 Y+0 Z-5 LEN15 RL F200
; contour goes along +y: PH (0, -15), in rapid as the block before, then down, then on to PA
4 L Y+50
5 DEP LT LEN20 F400
; on to (0, 70), compensation off
6 L X-50 Y-50 Z+10 R0 FMAX
7 APPR LN X+0 Y+0 LEN10 RR F200
; right of +y: PH (10, 0)
8 L Y+50
9 DEP LN LEN8
; (8, 50)
10 L X-50 Y-50 R0 FMAX
11 APPR CT X+0 Y+0 CCA90 R+10 RL F200
; center (-10, 0), arrives counter-clockwise: PH (-10, -10)
12 CR X+0 Y+40 R+20 DR+
; the arc begins along +x: center (0, 20); so the center of the approach is left of +x: (0, 10), PH (-10, 10)
13 DEP CT CCA180 R+5
; ends along -x, left is -y: center (0, 35), to (0, 30)
14 L X-50 Y+0 R0 F600
15 APPR LCT X+0 Y+0 Z-3 R10 RR F200
; contour along +y, center (10, 0), clockwise; the tangent from (-50, 0)
16 L Y+50
17 DEP LCT X+60 Y+50 Z+5 R10 F800
; center (10, 50), clockwise, tangent to (60, 50)
18 M30
19 END PGM APPROACH MM
