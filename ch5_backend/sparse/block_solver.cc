#include "ch5_backend/sparse/block_solver.h"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <set>
#include <string>
#include <typeindex>

namespace ch5 {
namespace {

constexpr int kLandmarks = 64;  // a task
constexpr int kEdges = 256;
constexpr int kPoses = 8;
constexpr int kAhead = 8;  // edges
constexpr int kVertices = 512;

// Then all blocks are where they were: an edge never changes its vertices.
bool IsSame(const Ordering& a, const Ordering& b) {
  return a.poses == b.poses && a.landmarks == b.landmarks && a.edges == b.edges;
}

bool FormsNoS(ReducedSolverType type) {
  return type == ReducedSolverType::kImplicitPcg || type == ReducedSolverType::kPowerSeries;
}

}  // namespace

BlockSolverBase::BlockSolverBase(Graph* graph, int pose_dim, int landmark_dim, int threads)
    : graph_(graph), pose_dim_(pose_dim), landmark_dim_(landmark_dim), pool_(threads) {}

// ---- structure -------------------------------------------------------------------------------------------------

void BlockSolverBase::SetOrdering() {
  has_solution_ = false;
  Ordering ordering = MakeOrdering(*graph_, selection_);
  if (ordered_ && IsSame(ordering, system_.structure.ordering)) return PackEdges();  // a loss may be another one
  ordered_ = false;
  system_.structure = BuildBlockStructure(std::move(ordering));
  CheckDimensions();
  system_.H_pp.SetPattern(system_.structure.pose_dim, system_.structure.H_pp_pattern);
  ChoosePasses();
  PackEdges();
  FindNumericJacobians();
  const BlockStructure& s = system_.structure;
  const auto size = [](int n) { return static_cast<size_t>(n); };
  system_.products.assign(size(s.num_product_values), 0.0);
  system_.H_pm.Take(s.num_H_pm_values);
  system_.H_mm.assign(size(s.num_H_mm_values), 0.0);
  system_.H_mm_inverse.assign(size(s.num_H_mm_values), 0.0);
  system_.H_mm_root.assign(size(s.num_H_mm_values), 0.0);
  system_.b.setZero(s.Size());
  system_.H_mm_inverse_b.setZero(s.ordering.dim_landmarks);
  for (VecX* v : {&system_.b_schur, &system_.scale, &delta_poses_, &H_delta_poses_}) v->setZero(s.ordering.dim_poses);
  TakeSums();
  PrepareReducedSolver();
  ordered_ = true;
}

void BlockSolverBase::SetReducedSolver(ReducedSolverType type, const IterativeOptions& options) {
  reduced_type_ = type;
  iterative_ = options;
  ordered_ = false;
  reduced_solver_.reset();
  implicit_.reset();
}

void BlockSolverBase::SetSinglePrecision(bool single_precision) {
  if (single_precision != single_precision_) ordered_ = false;
  single_precision_ = single_precision;
}

void BlockSolverBase::SetReducedSolver(std::unique_ptr<ReducedSolver> solver) {
  SetReducedSolver(ReducedSolverType::kDenseCholesky);  // any type that forms S
  reduced_solver_ = std::move(solver);
}

ReducedSolverType BlockSolverBase::ReducedType() const {
  return ChooseReducedSolver(reduced_type_, NumPoses(), system_.H_pp.NumBlocks() == NumPoses());
}

// One that is kept knows its last pattern, and need not plan anew for the same one.
void BlockSolverBase::PrepareReducedSolver() {
  const BlockStructure& s = system_.structure;
  const ReducedSolverType type = ReducedType();
  if (FormsNoS(type)) {
    reduced_solver_.reset();
    system_.S = SymmetricBlockMatrix();
    if (!implicit_) implicit_ = MakeImplicitSolver(type, iterative_, pose_dim_, landmark_dim_);
    implicit_->Prepare(&system_, &pool_);
  } else {
    implicit_.reset();
    system_.S.SetPattern(s.pose_dim, SchurPattern(s));
    if (!reduced_solver_) reduced_solver_ = MakeReducedSolver(type, pool_.Threads());
    reduced_solver_->Prepare(system_.S);
    schur_.Prepare(s, system_.S, pool_.Threads(), take_group_);
  }
}

void BlockSolverBase::TakeSums() {
  const BlockStructure& s = system_.structure;
  const int largest = s.pose_dim.empty() ? 0 : *std::max_element(s.pose_dim.begin(), s.pose_dim.end());
  system_.pose_stride = Stride(largest);
  system_.sums.resize(s.chunk_begin.empty() ? 0 : s.chunk_begin.size() - 1);
  for (PoseSums& sums : system_.sums) {
    sums.H_pp.assign(static_cast<size_t>(system_.H_pp.NumValues()), 0.0);
    sums.b.assign(s.poses.size() * static_cast<size_t>(system_.pose_stride), 0.0);
  }
}

// The dimensions of all blocks that landmarks meet, or Dynamic: speeds and biases have no part in a landmark's edges.
void BlockSolverBase::ChoosePasses() {
  const BlockStructure& s = system_.structure;
  const auto common = [](const auto& items, const std::vector<int>& dim) {
    int found = 0;
    for (const int item : items) {
      if (found != 0 && found != dim[item]) return Eigen::Dynamic;
      found = dim[item];
    }
    return found;
  };
  std::vector<int> landmarks(s.landmarks.size());
  std::iota(landmarks.begin(), landmarks.end(), 0);
  const int p = common(s.slot_pose, s.pose_dim), l = common(landmarks, s.landmark_dim);
  const bool fixed_size = PassesFor(p, l, false).fixed_size;
  const bool single = single_precision_ && fixed_size && !FormsNoS(ReducedType());
  system_.H_pm.single_precision = single;
  passes_ = &PassesFor(p, l, single);
  take_group_ = SchurGroupFor(p, l, single);
}

// Also where nothing else is new: a loss or a W may be another one. Those that are not packed need factors of their W.
void BlockSolverBase::PackEdges() {
  const bool were_packed = system_.packed.Active();
  passes_->fixed_size ? system_.packed.Assign(system_.structure) : system_.packed.Clear();
  const bool are_packed = system_.packed.Active();
  if (ordered_ && are_packed == were_packed) return;
  system_.factors.Prepare(system_.structure, are_packed ? system_.structure.num_landmark_edges : 0);
}

void BlockSolverBase::CheckDimensions() const {
  const auto check = [](const std::vector<Vertex*>& vertices, int dimension, const char* role) {
    for (const Vertex* vertex : vertices) {
      if (dimension == Eigen::Dynamic || vertex->LocalDimension() == dimension) continue;
      throw GraphError("BlockSolver: " + vertex->TypeInfo() + " " + std::to_string(vertex->Id()) + " has " +
                       std::to_string(vertex->LocalDimension()) + " degrees of freedom, but this solver is made for " +
                       role + " with " + std::to_string(dimension));
    }
  };
  check(system_.structure.poses, pose_dim_, "poses");
  check(system_.structure.landmarks, landmark_dim_, "landmarks");
}

// One edge of each type tells whether the type brings its own Jacobians.
void BlockSolverBase::FindNumericJacobians() {
  linearizing_pool_ = &pool_;
  if (pool_.Threads() == 1) return;
  std::set<std::type_index> seen;
  for (int e = 0; e < system_.structure.num_active_edges; ++e) {
    Edge& edge = *system_.structure.edges[e].edge;
    if (!seen.insert(typeid(edge)).second) continue;
    edge.Linearize();
    if (edge.HasNumericJacobians()) linearizing_pool_ = &one_thread_;
  }
}

// ---- H and b: landmark by landmark, then the poses' blocks column by column ------------------------------------

void BlockSolverBase::MakeHessian() {
  const BlockStructure& s = system_.structure;
  has_solution_ = false;
  if (system_.packed.Active()) system_.packed.LoadPoses();
  linearizing_pool_->Run(static_cast<int>(system_.sums.size()), [&](int c) { passes_->linearize_chunk(&system_, c); });
  ParallelFor(linearizing_pool_, s.num_active_edges - s.num_landmark_edges, kEdges, [&](int begin, int end) {
    for (int e = s.num_landmark_edges + begin; e < s.num_landmark_edges + end; ++e) {
      LinearizedProducts(s, e, &system_.factors, &system_.products[s.edges[e].products]);
    }
  });
  ParallelFor(&pool_, NumPoses(), kPoses, [&](int begin, int end) {
    for (int j = begin; j < end; ++j) passes_->sum_column(&system_, j);
  });
}

// ---- (H + λD) Δx = b -------------------------------------------------------------------------------------------

bool BlockSolverBase::SolveLinearSystem(double lambda, VecX* delta_x) {
  const BlockStructure& s = system_.structure;
  const DampingRule rule{lambda, GetDamping()};
  has_solution_ = false;

  // Step 1: H_ll⁻¹, damped before it is inverted.
  std::atomic<bool> ok{true};
  ParallelFor(&pool_, NumLandmarks(), kLandmarks, [&](int begin, int end) {
    if (!passes_->invert_landmarks(&system_, begin, end, rule)) ok = false;
  });
  if (!ok) return false;

  // Step 2: the Schur complement, a system of the poses alone.
  if (NumPoses() > 0 && !SolveReduced(rule)) return false;

  // Step 3: back to the landmarks; their parts of the model's decrease come along.
  delta_x->resize(s.Size());
  delta_x->head(s.ordering.dim_poses) = delta_poses_;
  system_.H_pp.Multiply(delta_poses_.data(), H_delta_poses_.data());
  const double of_poses = delta_poses_.dot(system_.b.head(s.ordering.dim_poses) - 0.5 * H_delta_poses_);
  const double of_landmarks = ParallelSum(&pool_, NumLandmarks(), kLandmarks, &parts_, [&](int begin, int end) {
    double sum = 0.0;
    for (int l = begin; l < end; ++l) sum += passes_->solve_landmark(system_, l, delta_x->data());
    return sum;
  });
  solution_ = *delta_x;
  has_solution_ = true;
  solution_decrease_ = of_poses + of_landmarks;
  return std::isfinite(solution_decrease_) && delta_x->allFinite();
}

bool BlockSolverBase::SolveReduced(const DampingRule& rule) {
  if (implicit_) return implicit_->Solve(&system_, rule, &delta_poses_);
  schur_.Compute(&system_, rule, &pool_);
  return reduced_solver_->Solve(system_.S, system_.b_schur, system_.scale, &delta_poses_);
}

double BlockSolverBase::PredictedDecrease(const VecX& delta_x) const {
  const bool is_solution = has_solution_ && delta_x.size() == solution_.size() && delta_x == solution_;
  return is_solution ? solution_decrease_ : NormalEquations::PredictedDecrease(delta_x);
}

VecX BlockSolverBase::MultiplyHessian(const VecX& v) const {
  VecX y = VecX::Zero(Size());
  system_.H_pp.Multiply(v.data(), y.data());
  pool_.Run(NumPoses(), [&](int j) { passes_->multiply_pose(system_, j, v.data(), y.data()); });
  ParallelFor(&pool_, NumLandmarks(), kLandmarks, [&](int begin, int end) {
    for (int l = begin; l < end; ++l) passes_->multiply_landmark(system_, l, v.data(), y.data());
  });
  return y;
}

// ---- states ----------------------------------------------------------------------------------------------------

double BlockSolverBase::ComputeChi() {
  const std::vector<EdgeRecord>& edges = system_.structure.edges;
  PackedEdges& packed = system_.packed;
  const int num_packed = packed.Active() ? system_.structure.num_landmark_edges : 0;
  if (num_packed > 0) packed.LoadPoses();
  return 0.5 * ParallelSum(&pool_, static_cast<int>(edges.size()), kEdges, &parts_, [&](int begin, int end) {
           double sum = begin < num_packed ? packed.RobustChi2(begin, std::min(end, num_packed)) : 0.0;
           for (int e = std::max(begin, num_packed); e < end; ++e) {
             PrefetchEdge(edges, e + kAhead);
             edges[e].edge->ComputeResidual();
             sum += edges[e].edge->RobustChi2();
           }
           return sum;
         });
}

void BlockSolverBase::UpdateStates(const VecX& delta_x) {
  for (const auto* vertices : {&system_.structure.poses, &system_.structure.landmarks}) {
    ParallelFor(&pool_, static_cast<int>(vertices->size()), kVertices, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        Vertex& vertex = *(*vertices)[i];
        vertex.BackUpParameters();
        vertex.Plus(delta_x.data() + vertex.OrderingId());
      }
    });
  }
}

void BlockSolverBase::RollbackStates() {
  for (Vertex* vertex : system_.structure.poses) vertex->RollBackParameters();
  for (Vertex* vertex : system_.structure.landmarks) vertex->RollBackParameters();
}

double BlockSolverBase::StateNorm() const {
  double sum = 0.0;
  for (const Vertex* vertex : system_.structure.poses) sum += vertex->Parameters().squaredNorm();
  for (const Vertex* vertex : system_.structure.landmarks) sum += vertex->Parameters().squaredNorm();
  return std::sqrt(sum);
}

// ---- H as a whole ----------------------------------------------------------------------------------------------

VecX BlockSolverBase::HessianDiagonal() const {
  const BlockStructure& s = system_.structure;
  VecX diagonal(s.Size());
  diagonal.head(s.ordering.dim_poses) = system_.H_pp.Diagonal();
  for (int l = 0; l < NumLandmarks(); ++l) {
    const int dim = s.landmark_dim[l];
    const double* H_ll = &system_.H_mm[s.landmark_block[l]];
    for (int i = 0; i < dim; ++i) diagonal[s.landmark_offset[l] + i] = H_ll[i * dim + i];
  }
  return diagonal;
}

MatXX BlockSolverBase::DenseHessian() const {
  const BlockStructure& s = system_.structure;
  MatXX H = MatXX::Zero(s.Size(), s.Size());
  H.topLeftCorner(s.ordering.dim_poses, s.ordering.dim_poses) = system_.H_pp.Dense();
  for (int l = 0; l < NumLandmarks(); ++l) {
    const int dim = s.landmark_dim[l], row = s.landmark_offset[l];
    H.block(row, row, dim, dim) = Eigen::Map<const MatXX>(&system_.H_mm[s.landmark_block[l]], dim, dim);
    for (int slot = s.landmark_slots[l]; slot < s.landmark_slots[l + 1]; ++slot) {
      const int pose = s.slot_pose[slot], pose_dim = s.pose_dim[pose];
      const MatXX W = system_.H_pm.Block(s.slot_block[slot], pose_dim, dim);
      H.block(s.pose_offset[pose], row, pose_dim, dim) = W;
      H.block(row, s.pose_offset[pose], dim, pose_dim) = W.transpose();
    }
  }
  return H;
}

}  // namespace ch5
