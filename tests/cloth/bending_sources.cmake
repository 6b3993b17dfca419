set(bending_tests bending_support.cpp delaunay.cpp test_bending_beams.cpp test_bending_elastica.cpp
                   test_bending_laws.cpp test_bending_robust.cpp)
