#pragma once
/// What H holds where none of the typical mistakes in MakeHessian explains it.

#include <string>
#include <utility>

#include "ch5_backend/math/psd.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/mistakes/assembly.h"

namespace ch5::homework::stage_1_1 {

// "2 × hessian − hessianᵀ"
inline std::string Terms(double plain, double transposed) {
  std::string terms;
  for (const auto& [times, name] : {std::pair{plain, "hessian"}, std::pair{transposed, "hessianᵀ"}}) {
    if (times == 0.0) continue;
    terms += terms.empty() ? (times < 0.0 ? "−" : "") : (times < 0.0 ? " − " : " + ");
    if (std::abs(times) != 1.0) terms += Number(std::abs(times)) + " × ";
    terms += name;
  }
  return terms.empty() ? "0" : terms;
}

/// H as a sum of `hessian` and its transpose at both places, so many times each, by least squares; the mistake that it
/// is, if these numbers are whole.
inline Mistake FoundPlaces(const Loop& loop, const MatXX& got) {
  const Turning places[] = {Three(kNothing, kFirst, kNothing), Three(kNothing, kFirst.Turned(), kNothing),
                            Three(kNothing, kMirror.Turned(), kNothing), Three(kNothing, kMirror, kNothing),
                            Three(kFirst, kNothing, kNothing)};
  MatXX basis(got.size(), 5);
  for (int k = 0; k < 5; ++k) basis.col(k) = AssembleH(loop, places[k]).reshaped();
  const MatXX finite = got.array().isFinite().select(got, 0.0);
  const VecX times =
      (PseudoInversePsd(basis.transpose() * basis) * (basis.transpose() * finite.reshaped())).array().round();
  const bool first_is_right = times[0] == 1.0 && times[1] == 0.0 && times[4] == 1.0;
  return {first_is_right ? "1.1b" : "1.1a",
          {"1.1.added_at",
           {{"first", Word(Terms(times[0], times[1]))},
            {"mirror", Word(Terms(times[2], times[3]))},
            {"diagonal", Word(Terms(times[4], 0.0))}}},
          (basis * times).reshaped(got.rows(), got.cols())};
}

}  // namespace ch5::homework::stage_1_1
