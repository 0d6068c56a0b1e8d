#pragma once
/// Solves a graph that grows, in time proportional to what changes: a small iSAM2.
///
///   IncrementalSmoother smoother(&graph);
///   for (…) {
///     graph.AddVertex(…);  graph.AddEdge(…);   // each new vertex where it is expected
///     smoother.Update();                       // one Gauss–Newton step; all vertices hold their estimates
///   }
///
/// Each variable has a linearization point θ, at which its factors have been linearized, and a step δ: its estimate is θ ⊞ δ.
///
///   Update:  θ ← θ ⊞ δ   of the variables with ‖δ‖∞ > relinearize_threshold      (fluid relinearization)
///            linearize   their edges, and the new ones
///            eliminate   the cliques that these touch, up to the root            (linear/bayes_tree.h)
///            solve       from the root down, as long as δ changes                (partial state updates)
///
/// With both thresholds 0 this is Gauss–Newton on the whole graph. There is no damping: each vertex has to begin where the
/// step from it makes sense, and its first edges must determine it.
///
/// Source: Kaess, Johannsson, Roberts, Ila, Leonard, Dellaert, "iSAM2: incremental smoothing and mapping using the Bayes
/// tree", IJRR 2012. Two things are simpler here: normal equations instead of QR, and AMD's order with the variables of new
/// edges put last instead of constrained COLAMD.

#include <stdexcept>
#include <unordered_map>
#include <unordered_set>

#include "ch5_backend/graph/graph.h"
#include "ch5_backend/linear/bayes_tree.h"

namespace ch5 {

/// The normal equations of a graph cannot be solved; the message names a vertex or an edge.
class SingularGraphError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Thresholds are compared with numbers of δ: meters and radians.
struct IncrementalOptions {
  double relinearize_threshold = 0.05;  ///< β: an estimate that is further from its θ moves it there
  double wildfire_threshold = 3e-4;     ///< α: a change of δ that is smaller is not passed on to the cliques below
};

/// How much an Update has done.
struct UpdateSummary {
  int variables = 0;     ///< of the whole graph
  int relinearized = 0;  ///< variables whose θ has moved
  int linearized = 0;    ///< edges
  int eliminated = 0;    ///< variables
  int solved = 0;        ///< variables whose δ has been computed and taken over
};

class IncrementalSmoother {
 public:
  /// The graph must outlive the smoother, which nobody else should move vertices of; it may grow between Updates.
  /// @throws OptionError if a threshold is negative or not a number
  explicit IncrementalSmoother(Graph* graph, const IncrementalOptions& options = {});

  /// Takes over the edges that the graph has got since, with their vertices, and makes one step; called again without new
  /// edges, another. A vertex without edges is not touched. Edges of other levels than 0 are ignored. If edges have been
  /// removed from the graph, it restarts.
  /// @throws SingularGraphError if a vertex is not determined (a gauge is free, for example), or an edge's numbers are not
  ///         finite. The estimates are then those before, and the next Update restarts
  UpdateSummary Update();
  /// The same, but takes over only these edges of the graph.
  /// @throws GraphError if one is not in the graph (or null), or has been taken over before
  UpdateSummary Update(const std::vector<std::shared_ptr<Edge>>& edges);

  /// Linearizes all edges that were taken over at the present states in the next Update. Needed after a vertex has been moved,
  /// fixed or freed, or a known edge's measurement, information, loss or level changed: that is not seen.
  void Restart() { restarts_ = true; }

  /// The marginal covariance of a vertex at the linearization points of the last Update, LocalDimension() square. It takes
  /// time proportional to the path to the root, which for the newest vertex is short.
  /// @throws GraphError if the vertex is fixed, or has taken no part in the last Update
  MatXX Covariance(const Vertex& vertex) const;

 private:
  struct Variable {
    std::shared_ptr<Vertex> vertex;
    VecX theta;
  };
  struct Factor {
    std::shared_ptr<Edge> edge;
    int width;              // of J
    bool is_stale = false;  // to be linearized
  };

  void RebuildIfNeeded();
  std::vector<std::shared_ptr<Edge>> NewEdges();
  UpdateSummary Step();
  void Take(const std::shared_ptr<Edge>& edge);
  int NumberOf(const std::shared_ptr<Vertex>& vertex);
  int Relinearize();
  void Linearize();
  void WriteEstimate(int variable);
  void GiveUp();

  GraphPointer graph_;
  IncrementalOptions options_;
  BayesTree tree_;
  std::vector<Variable> variables_;
  std::vector<Factor> factors_;
  std::unordered_map<const Vertex*, int> number_of_;
  std::unordered_set<const Edge*> known_;
  std::vector<int> candidates_;  // variables whose δ has changed since their θ was compared with it
  std::vector<int> stale_;       // factors
  bool restarts_ = false;        // in the next Update
  size_t removed_ = 0;           // Graph::NumRemovedEdges() at the last Update
};

}  // namespace ch5
