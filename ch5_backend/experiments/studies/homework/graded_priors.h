#pragma once
/// The priors of a window by the classes that students write. The estimators' own way, Marginalize, gives the same prior
/// sooner; here it is the graded lines that keep, or lose, what the window knew.

#include "ch5_backend/window/window.h"

namespace ch5 {

/// Stage 5: OKVIS's MarginalizationError, whose Residual is that of the prior.
std::shared_ptr<EdgePrior> PriorByMarginalizationError(const std::vector<std::shared_ptr<Edge>>& edges,
                                                       const std::vector<std::shared_ptr<Vertex>>& drop);

/// Stage 6A: VINS-Mono's MarginalizationInfo.
std::shared_ptr<EdgePrior> PriorByMarginalizationInfo(const std::vector<std::shared_ptr<Edge>>& edges,
                                                      const std::vector<std::shared_ptr<Vertex>>& drop);

}  // namespace ch5
