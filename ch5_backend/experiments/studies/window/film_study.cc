// Every slide of both policies' windows along one flight: the frames and how certain they are, H, what leaves it, and the prior.
// Of OKVIS's the first slide of either case is named.  Leutenegger et al., IJRR 2015, §4.3, Figs. 5–6
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "ch5_backend/experiments/studies/chapter_studies.h"
#include "ch5_backend/experiments/studies/matrices.h"
#include "ch5_backend/experiments/studies/window/flight.h"
#include "ch5_backend/experiments/studies/window/wrapped_policy.h"
#include "ch5_backend/files/tables/text_writer.h"
#include "ch5_backend/window/state_covariance.h"

namespace ch5 {
namespace {

constexpr size_t kFilmImages = 60;
constexpr int kFirstCase = 20;  // by then the window has been full for a while

struct FilmTables {
  // A row for each block on or below the diagonal that is not zero. `fill`: the slide has made it, H had none there.
  // window_row, window_column: where the prior's block stands in H.
  CsvTable blocks{"policy,image,case,stage,size,row,rows,column,columns,largest,fill,window_row,window_column"};
  CsvTable vertices{"policy,image,case,vertex,number,keyframe,row,rows,fate"};
  CsvTable frames{"policy,image,frame,x_m,y_m,xx_m2,xy_m2,yy_m2"};
};

// A block row of a matrix, and the one of H that has the same vertex.
struct BlockRow {
  int first, count, in_window;
};

std::vector<BlockRow> RowsOfWindow(const FirstRows& rows) {
  std::vector<BlockRow> blocks;
  for (const auto& [vertex, first] : rows) blocks.push_back({first, vertex->LocalDimension(), first});
  std::sort(blocks.begin(), blocks.end(), [](const BlockRow& a, const BlockRow& b) { return a.first < b.first; });
  return blocks;
}

std::vector<BlockRow> RowsOfPrior(const Prior& prior, const FirstRows& window) {
  std::vector<BlockRow> blocks;
  int row = 0;
  for (const auto& vertex : prior.vertices) {
    blocks.push_back({row, vertex->LocalDimension(), window.at(vertex.get())});
    row += vertex->LocalDimension();
  }
  return blocks;
}

// One slide, told to the tables.
class Slide {
 public:
  Slide(const std::string& policy, const Window& window)
      : policy_(policy),
        frames_(window.frames),
        rows_(FirstRowsOf(window.graph)),
        H_(DenseHessian(window.graph)),
        covariances_(PoseCovariances(window)) {
    for (const auto& [id, landmark] : window.landmarks) {
      if (rows_.count(landmark.inverse_depth.get())) landmarks_.emplace_back(id, landmark.inverse_depth);
    }
  }

  int Image() const { return frames_.back().id; }

  // "keyframe" or "no keyframe", whichever has left; "" if none has.
  std::string Case(const Window& after) const {
    for (const Frame& frame : frames_) {
      if (after.IndexOf(frame.id) < 0) return frame.is_keyframe ? "keyframe" : "no keyframe";
    }
    return "";
  }

  void Append(const Window& after, const std::string& name, const Recording& recording, FilmTables* tables) const {
    AppendBlocks(H_, RowsOfWindow(rows_), name, "window", &tables->blocks);
    const Prior& prior = after.prior->GetPrior();
    AppendBlocks(prior.J.transpose() * prior.J, RowsOfPrior(prior, rows_), name, "prior", &tables->blocks);
    AppendVertices(after, name, &tables->vertices);
    AppendFrames(recording, &tables->frames);
  }

 private:
  void AppendBlocks(const MatXX& M, const std::vector<BlockRow>& blocks, const std::string& name, const char* stage,
                    CsvTable* table) const {
    const auto largest = [](const MatXX& of, int row, int column, const BlockRow& i, const BlockRow& j) {
      return of.block(row, column, i.count, j.count).cwiseAbs().maxCoeff();
    };
    for (const BlockRow& i : blocks) {
      for (const BlockRow& j : blocks) {
        const double value = j.first <= i.first ? largest(M, i.first, j.first, i, j) : 0.0;
        if (value == 0.0) continue;
        table->Row(policy_, Image(), name, stage, M.rows(), i.first, i.count, j.first, j.count, value,
                   largest(H_, i.in_window, j.in_window, i, j) == 0.0, i.in_window, j.in_window);
      }
    }
  }

  void AppendVertices(const Window& after, const std::string& name, CsvTable* table) const {
    const auto append = [&](const char* kind, int number, bool is_keyframe, const Vertex* vertex, bool is_left) {
      table->Row(policy_, Image(), name, kind, number, is_keyframe, rows_.at(vertex), vertex->LocalDimension(),
                 FateOf(*vertex, is_left, after));
    };
    for (const Frame& frame : frames_) {
      const int at = after.IndexOf(frame.id);
      append("pose", frame.id, frame.is_keyframe, frame.pose.get(), at >= 0);
      if (!frame.speed_bias) continue;
      append("speed", frame.id, frame.is_keyframe, frame.speed_bias.get(),
             at >= 0 && after.frames[static_cast<size_t>(at)].speed_bias);
    }
    for (const auto& [id, vertex] : landmarks_)
      append("landmark", id, false, vertex.get(), after.landmarks.count(id) > 0);
  }

  // From above, laid upon the truth at the oldest frame by a shift and a turn about gravity: what errs there is what the
  // covariances, which hold the oldest frame, are about.
  void AppendFrames(const Recording& recording, CsvTable* table) const {
    const Frame& oldest = frames_.front();
    const Transform truth = StateAt(recording.truth, oldest.t)->T_W_B;
    const Mat33 turn = truth.q.toRotationMatrix() * oldest.pose->R().transpose();
    const Eigen::Rotation2Dd R(std::atan2(turn(1, 0) - turn(0, 1), turn(0, 0) + turn(1, 1)));
    for (size_t i = 0; i < frames_.size(); ++i) {
      const Vec2 p = truth.p.head<2>() + R * (frames_[i].pose->p() - oldest.pose->p()).head<2>();
      const Eigen::Matrix2d P = R * covariances_[i].topLeftCorner<2, 2>() * R.inverse();
      table->Row(policy_, Image(), frames_[i].id, p.x(), p.y(), P(0, 0), P(0, 1), P(1, 1));
    }
  }

  std::string policy_;
  std::vector<Frame> frames_;
  FirstRows rows_;
  MatXX H_;
  std::vector<Mat66> covariances_;  // of the frames' poses
  std::vector<std::pair<int, std::shared_ptr<Vertex>>> landmarks_;
};

}  // namespace

void RunFilmStudy(const std::filesystem::path& csv) {
  FlightOptions options;
  options.camera_rate = 15.0;
  options.max_tracks = 16;
  const Recording recording = Flight(options);
  FilmTables tables;
  for (const std::string policy : {"vins", "okvis"}) {
    std::set<std::string> named;
    const auto watch = [&](Window* window, const std::function<void()>& slide) {
      if (window->frames.size() < 2 || !window->prior) return slide();
      const Slide before(policy, *window);
      slide();
      std::string name = before.Case(*window);
      const bool is_first =
          policy == "okvis" && !name.empty() && before.Image() >= kFirstCase && named.insert(name).second;
      before.Append(*window, is_first ? name : "", recording, &tables);
    };
    Fly(recording, kFilmImages, std::make_unique<WrappedPolicy>(MakeFlightPolicy(policy), watch),
        [](const Estimator&, const ImageResult&) {});
  }
  for (size_t image = 0; image < kFilmImages; ++image) {
    const auto truth = StateAt(recording.truth, recording.images[image].t);
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    if (truth) tables.frames.Row("truth", image, image, truth->T_W_B.p.x(), truth->T_W_B.p.y(), kNone, kNone, kNone);
  }
  FileBatch files;
  files.Add(csv / "film_blocks.csv", tables.blocks.Text());
  files.Add(csv / "film_vertices.csv", tables.vertices.Text());
  files.Add(csv / "film_frames.csv", tables.frames.Text());
  files.Commit();
}

}  // namespace ch5
