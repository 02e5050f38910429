0 BEGIN PGM PLANE MM
1 TOOL CALL 1 Z S1000 F500
2 L X+0 Y+0 Z+100 R0 FMAX
3 L M140 MB 50
; straight along Z to 150
4 CYCL DEF 7.0 DATUM SHIFT
5 CYCL DEF 7.1 X+10
6 PLANE SPATIAL SPA+0 SPB+90 SPC+0 TURN FMAX SEQ- TABLE ROT
; z of the plane is x of the workpiece, its x is -z
7 L X+1 Y+2 Z+3 FMAX
; base (10 + 3, 2, -1)
8 CYCL DEF 7.0 DATUM SHIFT
9 CYCL DEF 7.1 X+5
; a shift in the plane: base -z by 5
10 L X+1 Y+2 Z+3 F500
11 PLANE RELATIVE SPC+90 STAY
12 L X+1 Y+2 Z+3
; in the plane (5, 0, 0) + (-2, 1, 3) = (3, 1, 3): base (10 + 3, 1, -3)
13 PLANE RESET TURN F2000
; the shift of X+5 takes the place of X+10
14 L X+0 Y+0 Z+150 FMAX
15 PLANE EULER EULPR+90 EULNU+30 EULROT-90 STAY
; about Z by 90, the new X by 30, the new Z by -90: z = Rz90 Rx30 e_z = Rz90 (0, -0.5, 0.866) = (0.5, 0, 0.866)
16 L B+Q121 C+Q122 FMAX
17 L X+0 Y+0 FMAX
; base coordinates need Z, which the program has not set: none is told
18 L Z+20 FMAX
19 L B+30 C+0 FMAX
; rotary axes alone turn with the linear axes at rest
20 PLANE VECTOR BX+1 BY+0 BZ+0 NX+0 NY-1 NZ+1 MOVE FMAX
; z = (0, -0.7071, 0.7071)
21 PLANE RESET MOVE FMAX
22 PLANE POINTS P1X+0 P1Y+0 P1Z+10 P2X+0 P2Y+10 P2Z+10 P3X-10 P3Y+0 P3Z+10 STAY
; x along +y, P3 on the side of +y: z = x cross (P3 - P1) = (0, 10, 0) cross (-10, 0, 0) = +z
23 L X+1 Y+0 Z+10 F100
; base (5, 1, 10)
24 PLANE RESET STAY
25 CYCL DEF 19.0 WORKING PLANE
26 CYCL DEF 19.1 A+0 B+0 C+30
27 L B+Q121 C+Q122 R0 FMAX
28 CYCL DEF 19.0 WORKING PLANE
29 CYCL DEF 19.1 A+0 B+0 C+0
30 L B+Q121 C+Q122 R0 FMAX
31 L M140 MB MAX
32 M30
33 END PGM PLANE MM
