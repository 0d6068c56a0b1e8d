#include "ch5_homework/judge/formula/expression.h"

#include <Eigen/LU>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "ch5_backend/math/psd.h"

namespace ch5::homework::formula {
namespace {

Expression Make(Node node) { return std::make_shared<const Node>(std::move(node)); }

bool IsPlain(const Expression& x, Kind kind) { return x->kind == kind && x->name.empty() && x->todo.empty(); }

std::optional<MatXX> InverseOf(const Node& x) {
  const auto& A = TryValue(x.parts[0]);
  if (!A || A->rows() != A->cols() || !A->allFinite()) return {};
  if (A->size() == 0) return A;
  const bool is_psd = A->isApprox(A->transpose(), 1e-9) && A->diagonal().minCoeff() >= -1e-9 * A->cwiseAbs().maxCoeff();
  if (!is_psd) return MatXX(A->inverse());
  if (x.sizes.empty()) return PseudoInversePsd(*A);
  MatXX inverse = MatXX::Zero(A->rows(), A->cols());
  Eigen::Index at = 0;
  for (const int size : x.sizes) {
    if (at + size > A->rows()) return {};
    const Eigen::LLT<MatXX> llt(A->block(at, at, size, size));
    if (llt.info() != Eigen::Success) return {};
    inverse.block(at, at, size, size) = llt.solve(MatXX::Identity(size, size));
    at += size;
  }
  return inverse;
}

std::optional<MatXX> ProductOf(const Node& x) {
  MatXX product;
  for (size_t k = 0; k < x.parts.size(); ++k) {
    const auto& next = TryValue(x.parts[k]);
    if (!next || (k > 0 && product.cols() != next->rows())) return {};
    product = k == 0 ? *next : MatXX(product * *next);
  }
  return product;
}

std::optional<MatXX> SumOf(const Node& x) {
  MatXX sum;
  for (size_t k = 0; k < x.parts.size(); ++k) {
    const auto& term = TryValue(x.parts[k]);
    if (!term || (k > 0 && (sum.rows() != term->rows() || sum.cols() != term->cols()))) return {};
    if (k == 0) sum = MatXX::Zero(term->rows(), term->cols());
    sum += x.factors[k] * *term;
  }
  return sum;
}

std::optional<MatXX> StackOf(const Node& x) {
  MatXX stack;
  for (size_t k = 0; k < x.parts.size(); ++k) {
    const auto& A = TryValue(x.parts[k]);
    if (!A || (k > 0 && A->cols() != stack.cols())) return {};
    stack.conservativeResize(stack.rows() + A->rows(), A->cols());
    stack.bottomRows(A->rows()) = *A;
  }
  return stack;
}

std::optional<MatXX> AssemblyOf(const Node& x) {
  MatXX sum = MatXX::Zero(x.rows, x.columns);
  for (size_t k = 0; k < x.parts.size(); ++k) {
    const auto& block = TryValue(x.parts[k]);
    if (!block) return {};
    const auto [row, column] = x.shares[k].place;
    if (row < 0 || column < 0 || row + block->rows() > x.rows || column + block->cols() > x.columns) continue;
    auto place = sum.block(row, column, block->rows(), block->cols());
    if (x.shares[k].assigned) place.setZero();
    place += *block;
  }
  return sum;
}

std::optional<MatXX> Compute(const Node& x) {
  switch (x.kind) {
    case Kind::kMatrix: return x.value;
    case Kind::kInverse: return InverseOf(x);
    case Kind::kTranspose: {
      const auto& A = TryValue(x.parts[0]);
      return A ? std::optional<MatXX>(A->transpose()) : std::nullopt;
    }
    case Kind::kProduct: return ProductOf(x);
    case Kind::kSum: return SumOf(x);
    case Kind::kStack: return StackOf(x);
    case Kind::kAssembly: return AssemblyOf(x);
    case Kind::kSeen: {
      const auto& A = TryValue(x.parts[0]);
      const bool fits = A && A->allFinite();
      return fits ? std::optional<MatXX>(x.seen(*A)) : std::nullopt;
    }
  }
  return {};
}

/// What ᵀ and ⁻¹ stand behind: also what has a name such as "J_iᵀ W J_j" gets brackets.
std::string BaseName(const Expression& x) {
  const std::string name = FactorName(x);
  const bool is_one = name.find(' ') == std::string::npos || name.front() == '(' || name.front() == '[';
  return is_one ? name : "(" + name + ")";
}

std::string NameOfSum(const Node& x) {
  std::string name;
  for (size_t k = 0; k < x.parts.size(); ++k) {
    const double factor = x.factors[k], times = std::abs(factor);
    if (k > 0) name += factor < 0.0 ? " − " : " + ";
    if (k == 0 && factor < 0.0) name += "−";
    name += times == 1.0 ? NameOf(x.parts[k]) : Number(times) + " " + FactorName(x.parts[k]);
  }
  return name;
}

}  // namespace

Source::Source(const std::string& name, const MatXX& A, const std::vector<Other>& others,
               const std::vector<Part>& parts)
    : data_(std::make_shared<const Data>(Data{name, A, others, parts})) {}

Expression Source::Block(const std::string& name, Eigen::Index row, Eigen::Index column, Eigen::Index rows,
                         Eigen::Index columns, const std::string& todo) const {
  const MatXX value = data_->A.block(row, column, rows, columns);
  return Make({Kind::kMatrix, name, todo, {}, {}, {}, value, data_, row, column});
}

Expression Matrix(const std::string& name, const MatXX& value, const std::string& todo) {
  return Make({Kind::kMatrix, name, todo, {}, {}, {}, value});
}

Expression Named(const Expression& x, const std::string& name, const std::string& todo) {
  Node node = *x;
  node.name = name;
  if (!todo.empty()) node.todo = todo;
  return Make(node);
}

Expression MistakenFor(const Expression& x, const std::vector<Instead>& others) {
  Node node = *x;
  node.mistaken = others;
  return Make(node);
}

Expression WrittenAt(const std::string& todo, const Expression& x) { return Named(x, x->name, todo); }

Expression Inverse(const Expression& x, const std::vector<int>& sizes) {
  return Make({Kind::kInverse, {}, {}, {x}, {}, sizes});
}

Expression Transpose(const Expression& x) { return Make({Kind::kTranspose, {}, {}, {x}}); }

Expression Assembly(const std::string& name, Eigen::Index rows, Eigen::Index columns, std::vector<Share> shares) {
  Node node{Kind::kAssembly, name};
  node.rows = rows;
  node.columns = columns;
  for (const Share& share : shares) node.parts.push_back(share.x);
  node.shares = std::move(shares);
  return Make(std::move(node));
}

Expression Stack(const std::vector<Expression>& parts) { return Make({Kind::kStack, {}, {}, parts}); }

Expression Seen(const Expression& x, const std::function<MatXX(const MatXX& x)>& how) {
  Node node{Kind::kSeen, {}, {}, {x}};
  node.seen = how;
  return Make(node);
}

Expression Sum(const std::vector<Expression>& terms, const std::vector<double>& factors) {
  Node node{Kind::kSum};
  for (size_t k = 0; k < terms.size(); ++k) {
    const bool flat = IsPlain(terms[k], Kind::kSum);
    for (size_t l = 0; flat && l < terms[k]->parts.size(); ++l) {
      node.parts.push_back(terms[k]->parts[l]);
      node.factors.push_back(factors[k] * terms[k]->factors[l]);
    }
    if (flat) continue;
    node.parts.push_back(terms[k]);
    node.factors.push_back(factors[k]);
  }
  return Make(node);
}

Expression Product(const std::vector<Expression>& factors) {
  std::vector<Expression> flat;
  for (const Expression& factor : factors) {
    if (IsPlain(factor, Kind::kProduct)) {
      flat.insert(flat.end(), factor->parts.begin(), factor->parts.end());
    } else {
      flat.push_back(factor);
    }
  }
  return flat.size() == 1 ? flat[0] : Make({Kind::kProduct, {}, {}, flat});
}

Expression operator+(const Expression& a, const Expression& b) { return Sum({a, b}, {1.0, 1.0}); }
Expression operator-(const Expression& a, const Expression& b) { return Sum({a, b}, {1.0, -1.0}); }
Expression operator-(const Expression& a) { return Sum({a}, {-1.0}); }
Expression operator*(const Expression& a, const Expression& b) { return Product({a, b}); }
Expression operator*(double factor, const Expression& a) { return Sum({a}, {factor}); }

const std::optional<MatXX>& TryValue(const Expression& x) {
  if (!x->known) x->known = Compute(*x);
  return *x->known;
}

const MatXX& Value(const Expression& x) {
  const auto& value = TryValue(x);
  if (!value) throw std::logic_error("the sizes of " + NameOf(x) + " do not fit");
  return *value;
}

std::string NameOf(const Expression& x) {
  if (!x->name.empty()) return x->name;
  std::string name;
  switch (x->kind) {
    case Kind::kMatrix:
    case Kind::kAssembly: return name;
    case Kind::kInverse: return BaseName(x->parts[0]) + "⁻¹";
    case Kind::kTranspose: {
      const std::string base = BaseName(x->parts[0]), mark = "ᵀ";
      const bool twice = base.size() > mark.size() && base.compare(base.size() - mark.size(), mark.size(), mark) == 0;
      return twice ? base.substr(0, base.size() - mark.size()) : base + mark;
    }
    case Kind::kProduct:
      for (const Expression& part : x->parts) {
        name += (name.empty() ? "" : " ") + (part->kind == Kind::kProduct ? NameOf(part) : FactorName(part));
      }
      return name;
    case Kind::kSum: return NameOfSum(*x);
    case Kind::kStack:
      for (const Expression& part : x->parts) name += (name.empty() ? "[" : "; ") + NameOf(part);
      return name + "]";
    case Kind::kSeen: return NameOf(x->parts[0]);
  }
  return name;
}

std::string FactorName(const Expression& x) {
  const bool brackets = x->name.empty() && (x->kind == Kind::kSum || x->kind == Kind::kProduct);
  return brackets ? "(" + NameOf(x) + ")" : NameOf(x);
}

}  // namespace ch5::homework::formula
