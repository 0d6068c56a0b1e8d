#pragma once
/// Composition and inverse of rigid transforms. T_A_B maps B-coordinates into A; neighbors cancel: T_W_C = T_W_B * T_B_C.

#include "ch5_backend/math/so3.h"

namespace ch5 {

/// p_A = q p_B + p.
inline Vec3 operator*(const Transform& T_A_B, const Vec3& p_B) { return T_A_B.q * p_B + T_A_B.p; }
/// T_A_C.
inline Transform operator*(const Transform& T_A_B, const Transform& T_B_C) {
  return {T_A_B.q * T_B_C.q, T_A_B * T_B_C.p};
}
/// T_B_A.
inline Transform Inverse(const Transform& T_A_B) { return {T_A_B.q.conjugate(), T_A_B.q.conjugate() * -T_A_B.p}; }

}  // namespace ch5
