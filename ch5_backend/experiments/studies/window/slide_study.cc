#include <algorithm>

#include "ch5_backend/consistency/gauge_audit.h"
#include "ch5_backend/experiments/studies/chapter_studies.h"
#include "ch5_backend/experiments/studies/window/film.h"
#include "ch5_backend/experiments/studies/window/flight.h"
#include "ch5_backend/files/tables/text_writer.h"

namespace ch5 {
namespace {

constexpr size_t kImages = 30, kFilmed = 60;

struct Tables {
  CsvTable vertices{"policy,vertex,number,row,rows,fate"};
  CsvTable observations{"policy,landmark,frame,host,fate"};
  CsvTable matrices{"policy,stage,size,pose_rows,row,column,value"};
  CsvTable priors{"policy,stage,columns,rank,null_dimension,largest_gauge_information"};
  CsvTable frames{"policy,image,frame,keyframe,speed,in_prior,prior_columns"};
};

void AppendPrior(const std::string& policy, const std::string& stage, const Prior& prior, Tables* tables) {
  const MatXX H = prior.J.transpose() * prior.J;
  double largest = 0.0;
  for (const GaugeLeak& leak : AuditPrior(prior)) largest = std::max(largest, std::abs(leak.information));
  tables->priors.Row(policy, stage, H.rows(), prior.J.rows(), NullDimension(H), largest);
  AppendNonZeros(H, &tables->matrices, policy, stage, H.rows(), H.rows());
}

// What has become of each observation.
void AppendObservations(const WindowBefore& before, const Window& after, CsvTable* table) {
  for (const auto& [id, landmark] : before.landmarks) {
    const bool is_taken = before.IsTaken(id, landmark, after);
    for (const WindowObservation& seen : landmark.seen) {
      const auto left = after.landmarks.find(id);
      const bool is_left = left != after.landmarks.end() && left->second.In(seen.frame) != nullptr;
      const char* fate = is_taken ? (is_left ? "again" : "prior") : (is_left ? "stays" : "lost");
      table->Row(before.policy, id, seen.frame, seen.frame == landmark.Host(), fate);
    }
  }
}

// Lets the window grow to kFlightWindow frames with all their states; then the policy in question slides it.
class SlideOnce : public WindowPolicy {
 public:
  SlideOnce(std::unique_ptr<WindowPolicy> policy, Tables* tables) : policy_(std::move(policy)), tables_(*tables) {}
  std::string Name() const override { return policy_->Name(); }
  void NoteNewFrame(Window*) override {}
  bool Uses(const Window&, const WindowLandmark& landmark) const override { return landmark.seen.size() >= 2; }
  SolveOptions Options() const override { return {}; }
  size_t MostFrames() const override { return std::numeric_limits<size_t>::max(); }

  void Slide(Window* window) override {
    if (window->frames.size() < kFlightWindow) return;
    policy_->NoteNewFrame(window);
    BuildGraph(
        {}, [&](const Window& w, const WindowLandmark& l) { return policy_->Uses(w, l); }, window);
    const WindowBefore before(Name(), *window);
    const int pose_rows = MakeOrdering(window->graph).dim_poses;
    AppendNonZeros(before.H, &tables_.matrices, Name(), "window", before.H.rows(), pose_rows);
    AppendPrior(Name(), "before", window->prior->GetPrior(), &tables_);
    policy_->Slide(window);
    before.ForEachVertex(*window, [&](const char* kind, int id, bool, const Vertex& vertex, const char* fate) {
      tables_.vertices.Row(Name(), kind, id, before.rows.at(&vertex), vertex.LocalDimension(), fate);
    });
    AppendObservations(before, *window, &tables_.observations);
    AppendPrior(Name(), "after", window->prior->GetPrior(), &tables_);
  }

 private:
  std::unique_ptr<WindowPolicy> policy_;
  Tables& tables_;
};

// The policy's own windows, from the start on.
void AppendFrames(const Recording& recording, const std::string& name, Tables* tables, FilmTables* film) {
  size_t image = 0;
  auto policy = Filmed(MakeFlightPolicy(name), recording.truth, 1, film);
  Fly(recording, kFilmed, std::move(policy), [&](const Estimator& now, const ImageResult&) {
    if (image == kImages) return;
    const Window& window = now.GetWindow();
    for (const Frame& frame : window.frames) {
      tables->frames.Row(name, image, frame.id, frame.is_keyframe, frame.speed_bias != nullptr,
                         IsInPrior(window, *frame.pose), window.prior->GetPrior().J.cols());
    }
    ++image;
  });
}

}  // namespace

void RunSlideStudy(const std::filesystem::path& csv) {
  const Recording wide = Flight({});
  Recording dense = Flight({/*camera_rate=*/15.0});
  dense.images.resize(kFilmed);
  Tables tables;
  FilmTables film;
  film.AppendTruth(dense);
  for (const char* name : {"vins", "okvis"}) {
    Fly(wide, kFlightWindow, std::make_unique<SlideOnce>(MakeFlightPolicy(name), &tables),
        [](const Estimator&, const ImageResult&) {});
    AppendFrames(dense, name, &tables, &film);
  }
  FileBatch files;
  files.Add(csv / "slide_vertices.csv", tables.vertices.Text());
  files.Add(csv / "slide_observations.csv", tables.observations.Text());
  files.Add(csv / "slide_matrices.csv", tables.matrices.Text());
  files.Add(csv / "slide_priors.csv", tables.priors.Text());
  files.Add(csv / "slide_frames.csv", tables.frames.Text());
  film.AddTo(csv, &files);
  files.Commit();
}

}  // namespace ch5
