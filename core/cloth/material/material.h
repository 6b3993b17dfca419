// Material parameters of a cloth. Axis 1 is weft and axis 2 is warp. Membrane stiffness is a
// modulus times the thickness [N/m].
#pragma once

#include "core/base/field.h"

namespace loomstone {

struct ClothMaterial {
  double weft_stiffness = 300.0;   // E1
  double warp_stiffness = 300.0;   // E2
  double shear_stiffness = 150.0;  // G
  double poisson = 0.0;            // nu12: contraction along warp / extension along weft
  double density = 0.3;
  double bending_weft = 1e-5;
  double bending_warp = 1e-5;
  double bending_twist = -1.0;
  double bending_coupling = 0.0;
  double viscosity_dilation = 0.0;  // lambda_d
  double viscosity_shear = 0.0;     // mu_d
  double bending_damping = 0.0;

  static auto fields() {
    using M = ClothMaterial;
    return std::make_tuple(
        field("weft_stiffness", &M::weft_stiffness, "N/m", positive(),
              "Young's modulus times thickness along weft"),
        field("warp_stiffness", &M::warp_stiffness, "N/m", positive(),
              "Young's modulus times thickness along warp"),
        field("shear_stiffness", &M::shear_stiffness, "N/m", positive(),
              "shear modulus times thickness"),
        field("poisson", &M::poisson, "1", between(-1.0, 1.0),
              "Poisson ratio nu12: contraction along warp under tension along weft"),
        field("density", &M::density, "kg/m^2", positive(), "mass per area"),
        field("bending_weft", &M::bending_weft, "N m", non_negative(),
              "flexural rigidity along weft"),
        field("bending_warp", &M::bending_warp, "N m", non_negative(),
              "flexural rigidity along warp"),
        field("bending_twist", &M::bending_twist, "N m", unlimited(),
              "twist rigidity (coefficient of 2 kxy), >= 0; -1: Huber's, "
              "(sqrt(bending_weft bending_warp) - bending_coupling) / 2"),
        field("bending_coupling", &M::bending_coupling, "N m", unlimited(),
              "coupling rigidity of curvatures along weft and warp"),
        field("viscosity_dilation", &M::viscosity_dilation, "N s/m", unlimited(),
              "dilational viscosity lambda_d, equation (2.25)"),
        field("viscosity_shear", &M::viscosity_shear, "N s/m", non_negative(),
              "shear viscosity mu_d, equation (2.25)"),
        field("bending_damping", &M::bending_damping, "s", non_negative(),
              "stiffness-proportional damping of bending"));
  }
};

}  // namespace loomstone
