set(bending_sources hinge.cpp hinge_kernels.cpp hinge_hessian.cpp hinge_stiffness.cpp stiffness_kernels.cpp bending_setup.cpp
                    hinge_bending.cpp midedge_setup.cpp midedge_bending.cpp)
