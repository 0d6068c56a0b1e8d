/// marginalization_error.cc, stage 5: each function on numbers of its own, then the whole term.

#include <tuple>

#include "ch5_backend/marginalize/marginalization_error.h"
#include "ch5_homework/judge/checks/check.h"
#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework {
namespace {

// Protected members.
struct Access : ch5::MarginalizationError {
  using MarginalizationError::b0_;
  using MarginalizationError::dense_size_;
  using MarginalizationError::e0_;
  using MarginalizationError::H_;
  using MarginalizationError::J_;
};
// H, J, b₀, e₀ and the size of the dense part.
auto MembersOf(ch5::MarginalizationError& term) {
  return std::tie(term.*(&Access::H_), term.*(&Access::J_), term.*(&Access::b0_), term.*(&Access::e0_),
                  term.*(&Access::dense_size_));
}

void InsertBlock(const Submission& student, const Values& given, Answer* answer) {
  const auto term = student.make_marginalization_error();
  const auto [H, J, b0, e0, dense_size] = MembersOf(*term);
  H = given["H"];
  b0 = given.Vector("b0");
  dense_size = given.Int("dense_size");
  const int row = term->InsertBlock(given.Int("dim"), given.Int("is_landmark") != 0);
  answer->Put({{"H", H}, {"b0", b0}, {"dense_size", dense_size}, {"row", row}});
}

void Eliminate(const Submission& student, const Values& given, Answer* answer) {
  MatXX U = given["U"];
  VecX b_a = given.Vector("b_a");
  student.make_marginalization_error()->SchurComplement(given["V"], given["W"], given.Vector("b_b"), &U, &b_a);
  answer->Put({{"U", U}, {"b_a", b_a}});
}

// Twice: what is left of an earlier time must not show.
void UpdateErrorComputation(const Submission& student, const Values& given, Answer* answer) {
  const auto term = student.make_marginalization_error();
  const auto [H, J, b0, e0, dense_size] = MembersOf(*term);
  H = 5.0 * given["H"];
  b0 = 3.0 * given.Vector("b0");
  term->UpdateErrorComputation();
  answer->Put({{"J_before", J}, {"e0_before", e0}});
  H = given["H"];
  b0 = given.Vector("b0");
  term->UpdateErrorComputation();
  answer->Put({{"J", J}, {"e0", e0}});
}

// Of each column δχ.
void Residual(const Submission& student, const Values& given, Answer* answer) {
  const auto term = student.make_marginalization_error();
  const auto [H, J, b0, e0, dense_size] = MembersOf(*term);
  J = given["J"];
  e0 = given.Vector("e0");
  const MatXX& delta_chi = given["delta_chi"];
  for (Eigen::Index k = 0; k < delta_chi.cols(); ++k) {
    answer->Put(Numbered("e", k), term->Residual(delta_chi.col(k)));
  }
}

// All edges of the scene; its vertices at these places leave in this order.
void WholeTerm(const Submission& student, const Values& given, Answer* answer) {
  const auto scene = MakeScene<GraphScene>(given);
  const auto term = student.make_marginalization_error();
  for (const auto& edge : scene->graph.Edges()) term->AddResidualBlock(edge);
  VertexList out;
  for (const double place : given.Vector("out")) out.push_back(scene->graph.Vertices().at(static_cast<size_t>(place)));
  term->MarginalizeOut(out);
  term->UpdateErrorComputation();
  answer->Put({{"H", term->H()}, {"b0", term->b0()}, {"J", term->J()}});
}

[[maybe_unused]] const bool added =
    (Linked()->make_marginalization_error = &Make<ch5::MarginalizationError, MarginalizationError>,
     AddChecks({{"InsertBlock", &InsertBlock},
                {"MarginalizationError::SchurComplement", &Eliminate},
                {"UpdateErrorComputation", &UpdateErrorComputation},
                {"Residual", &Residual},
                {"MarginalizationError", &WholeTerm}}));

}  // namespace
}  // namespace ch5::homework
