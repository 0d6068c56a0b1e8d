#pragma once
/// What the studies show of a matrix: its eigenvalues, how many of them a free gauge makes zero, and its entries as rows
/// of a table; which vertices and edges made which block of H and of its Schur complement.

#include <string>
#include <unordered_map>

#include "ch5_backend/files/tables/csv.h"
#include "ch5_backend/graph/graph.h"

namespace ch5 {

/// Ascending eigenvalues of a symmetric H (n×n).
VecX Eigenvalues(const MatXX& H);

/// How many eigenvalues are zero next to the largest one: ≤ `relative`·λ_max. H is scaled to a unit diagonal first,
/// so that meters, radians and inverse meters can be compared; scaling keeps the rank.
int NullDimension(const MatXX& H, double relative = 1e-10);

/// The first row of each free vertex with an edge, in the graph's order, which has the landmarks last.
using FirstRows = std::unordered_map<const Vertex*, int>;
FirstRows FirstRowsOf(const Graph& graph);

/// H of the dense solver at the present states, in that order.
MatXX DenseHessian(const Graph& graph);

/// H of the slides' chain of three scalars: x₁ is measured, and its distances to x₀ and x₂.
///
///   H = [  w₁      −w₁       0  ]     w_i = 1/σ_i²,  σ = 0.1, 0.2, 0.3:
///       [ −w₁  w₁+w₂+w₃    −w₃  ]     σ₁ and σ₃ of the distances, σ₂ of x₁ itself
///       [   0      −w₃      w₃  ]
MatXX SlidesChain();

/// Appends the entries of M that are not zero, `labels…,row,column,value`.
template <typename... Labels>
void AppendNonZeros(const MatXX& M, CsvTable* table, const Labels&... labels) {
  for (int row = 0; row < M.rows(); ++row) {
    for (int column = 0; column < M.cols(); ++column) {
      if (M(row, column) != 0.0) table->Row(labels..., row, column, M(row, column));
    }
  }
}

struct HessianBlockTables {
  CsvTable vertices{"scene,vertex,type,number,first_row,rows"};  ///< `number` counts the vertices of a type
  CsvTable edges{"scene,edge,type,vertex"};                      ///< a row for each vertex of an edge, in its order
  CsvTable blocks{"scene,matrix,row_vertex,column_vertex,by,number"};  ///< lower half; a row for each that added to it
};

/// Appends the free vertices, the edges, and what each adds to:
///
///   H_ij += J_iᵀ W J_j               each edge, to the blocks of all pairs of its vertices     by = edge
///   S_ij −= H_il H_ll⁻¹ H_lj         each landmark, to those of all pairs of poses that see it  by = landmark
///
/// S has the edges between poses too. Vertices and edges go by their ids.
void AppendHessianBlocks(const Graph& graph, const std::string& scene, HessianBlockTables* tables);

}  // namespace ch5
