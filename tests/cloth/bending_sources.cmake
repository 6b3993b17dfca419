set(bending_tests bending_support.cpp test_bending_beams.cpp)
