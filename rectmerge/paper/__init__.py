"""The paper's method, one file per algorithm, with every equation and line marked where it happens.

`Paper` (merging.py) is the method to the letter, `PaperRepaired` (repaired.py) the same loop with repairs as switches.

========== ============================================== ====================================================
mark       content                                        module
========== ============================================== ====================================================
eq. (1)    free cells as a binary matrix                  rectmerge/rectangles.py
eq. (2)    contiguous free cells to the right             rectmerge/_kernels/runs.py
eq. (3)    cells along the four sides of a rectangle      rectmerge/_kernels/neighbours.py
eq. (4)    connections: the labels there without 0        rectmerge/_kernels/neighbours.py
eq. (5)    rectangles along an edge, in two directions    rectmerge/paper/edges.py
eq. (6)    rectangles along an edge                       rectmerge/paper/edges.py
eq. (7)    number of lines of an edge                     rectmerge/_kernels/orientation.py
eq. (8)    corresponding rectangles                       rectmerge/paper/triangles.py
eq. (9)    number of triangles                            rectmerge/paper/triangles.py
eq. (10)   feature vector of a triangle                   rectmerge/_kernels/triangles.py
eq. (11)   cost of a pair of triangles                    rectmerge/_kernels/triangles.py
eq. (12)   shared triangles in the order of size          rectmerge/paper/triangles.py
eq. (13)   scale ratio                                    rectmerge/paper/iteration.py
Alg. 1     maximal empty rectangle                        rectmerge/paper/largest.py, rectmerge/rectangles.py,
                                                          rectmerge/_kernels/rectangles.py,
                                                          rectmerge/_kernels/runs.py
Alg. 2     rectangular map                                rectmerge/paper/rmap.py, rectmerge/_kernels/rmap.py
Alg. 3     orthogonal orientation                         rectmerge/paper/orientation.py, rectmerge/paper/edges.py,
                                                          rectmerge/_kernels/orientation.py
Alg. 4     shared triangles                               rectmerge/paper/triangles.py,
                                                          rectmerge/_kernels/triangles.py
Alg. 5     map merging                                    rectmerge/paper/merging.py, rectmerge/paper/iteration.py
========== ============================================== ====================================================
"""
