#pragma once
/// The course's matrix names. Dynamic: VecX, MatXX; fixed: Vec3, Mat33, Mat66 …; quaternion Qd (x, y, z, w).
///
/// And their alignment, which Eigen chooses by the instruction set of the file at hand by default: a class with
/// a quaternion would have one layout in the library and another in a program that is compiled with -mavx2, and memory that
/// one allocates would be freed wrongly by the other. Here it is the same for every instruction set: 16 bytes for what has a
/// fixed size, and on the heap the 64 bytes of the widest registers. Wider registers are used all the same; the processor
/// reads them from any address.

#if __cplusplus < 201703L
#error "ch5_backend needs C++17 or later: compile with -std=c++17"
#endif

#ifndef EIGEN_MAX_ALIGN_BYTES
#define EIGEN_MAX_ALIGN_BYTES 64
#endif
#ifndef EIGEN_MAX_STATIC_ALIGN_BYTES
#define EIGEN_MAX_STATIC_ALIGN_BYTES 16
#endif

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#if EIGEN_MAX_ALIGN_BYTES != 64 || EIGEN_DEFAULT_ALIGN_BYTES != 64 || EIGEN_MAX_STATIC_ALIGN_BYTES != 16 || \
    EIGEN_MALLOC_ALREADY_ALIGNED
#error \
    "ch5_backend needs Eigen's alignment as it was compiled with; give all files of your program the flags \
-DEIGEN_MAX_ALIGN_BYTES=64 -DEIGEN_MAX_STATIC_ALIGN_BYTES=16, as the CMake target ch5::backend does"
#endif

namespace ch5 {

using VecX = Eigen::VectorXd;
using MatXX = Eigen::MatrixXd;
static_assert(!MatXX::IsRowMajor && sizeof(MatXX::Index) == sizeof(std::ptrdiff_t),
              "ch5_backend was compiled without EIGEN_DEFAULT_TO_ROW_MAJOR and EIGEN_DEFAULT_DENSE_INDEX_TYPE");

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Vec7 = Eigen::Matrix<double, 7, 1>;
using Vec9 = Eigen::Matrix<double, 9, 1>;

using Mat22 = Eigen::Matrix2d;
using Mat23 = Eigen::Matrix<double, 2, 3>;
using Mat26 = Eigen::Matrix<double, 2, 6>;
using Mat33 = Eigen::Matrix3d;
using Mat66 = Eigen::Matrix<double, 6, 6>;

using Qd = Eigen::Quaterniond;

/// Never called. It has another name for the linker with -D_GLIBCXX_DEBUG, with -D_GLIBCXX_USE_CXX11_ABI=0 and in another
/// standard library, whose vectors and strings have another layout: such a program does not link, where it would crash.
void SameStandardLibrary(const std::vector<std::string>&);
[[gnu::used]] void (*const kSameStandardLibrary)(const std::vector<std::string>&) = SameStandardLibrary;

}  // namespace ch5
