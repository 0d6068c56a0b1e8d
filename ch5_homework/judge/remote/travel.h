#pragma once
/// A graded function on both sides of the wire, described once: struct F { static constexpr char kName[]; static R Run(A…); }.
/// The judge calls Ask<F>(arguments…), the worker runs F::Run. How each kind of argument travels:
///
///   T, const T&      a value, to the worker
///   T*               a value, to the worker and back
///   S&               a scene: its name, sizes and seed, how many steps it has gone, and its vertices' states; nothing else
///   RemoteObject<T>  an object of the student's class, which the worker keeps: its members, to the worker and back
///
/// What F::Run returns comes back.

#include <map>
#include <memory>
#include <tuple>

#include "ch5_homework/judge/remote/wire.h"
#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework {

// ---- scenes ----------------------------------------------------------------------------------------------------------

/// Parameters of vertices, and whether each is fixed.
struct States {
  std::vector<VecX> x;
  std::vector<int> fixed;  ///< 0 or 1

  States() = default;
  explicit States(const VertexList& vertices);
  /// @throws WireError unless there is one for each vertex, and of its size
  void SetInto(const VertexList& vertices) const;
  /// @throws WireError if a number is not finite
  void RequireFinite() const;
};
inline auto Fields(States& states, Wire) { return std::tie(states.x, states.fixed); }

void SendScene(Scene* scene, Writer* out);
/// The worker's scene, built at its first use, in the judge's state.
Scene* FetchScene(Reader* in);

/// The place of a vertex or an edge in a list: kNull of a null pointer, kUnknown if it is not there.
constexpr int kNull = -1, kUnknown = -2;
template <typename T>
int PlaceOf(const std::shared_ptr<T>& item, const std::vector<std::shared_ptr<T>>& list) {
  if (item == nullptr) return kNull;
  for (size_t k = 0; k < list.size(); ++k) {
    if (list[k] == item) return static_cast<int>(k);
  }
  return kUnknown;
}
template <typename T>
std::vector<int> PlacesOf(const std::vector<std::shared_ptr<T>>& items, const std::vector<std::shared_ptr<T>>& list) {
  std::vector<int> places;
  for (const auto& item : items) places.push_back(PlaceOf(item, list));
  return places;
}
/// @throws WireError if one is not in the list
template <typename T>
std::vector<std::shared_ptr<T>> At(const std::vector<int>& places, const std::vector<std::shared_ptr<T>>& list) {
  std::vector<std::shared_ptr<T>> items;
  for (const int place : places) {
    if (place < 0 || place >= static_cast<int>(list.size())) throw WireError("a place that is not in the scene");
    items.push_back(list[static_cast<size_t>(place)]);
  }
  return items;
}

// ---- objects of the student's classes --------------------------------------------------------------------------------

/// How the worker makes one, and which members travel; specialized for each class:
///   static std::unique_ptr<T> Make(Scene* scene);   static std::tuple<M&…> Members(T& object);
template <typename T>
struct ObjectOf;

template <typename T>
struct RemoteObject {
  int handle = 0;  ///< the judge's number of the object
  Scene* scene = nullptr;
  T* object = nullptr;
};

/// The worker's, for one test.
template <typename T>
T* Kept(int handle, Scene* scene) {
  static std::map<int, std::unique_ptr<T>> kept;
  auto& object = kept[handle];
  if (!object) object = ObjectOf<T>::Make(scene);
  return object.get();
}

// ---- arguments -------------------------------------------------------------------------------------------------------

template <typename T, typename = void>
struct Travel {
  using Held = std::decay_t<T>;
  static void Send(const Held& value, Writer* out) { *out << value; }
  static void Fetch(Reader* in, Held* held) { *in >> *held; }
  static T Pass(Held& held) { return held; }
  static void GiveBack(const Held&, Writer*) {}
  static void TakeBack(Reader*, const Held&) {}
};
template <typename T>
struct Travel<T*> {
  using Held = T;
  static void Send(const T* value, Writer* out) { *out << *value; }
  static void Fetch(Reader* in, T* held) { *in >> *held; }
  static T* Pass(T& held) { return &held; }
  static void GiveBack(const T& held, Writer* out) { *out << held; }
  static void TakeBack(Reader* in, T* value) { *in >> *value; }
};
template <typename S>
struct Travel<S&, std::enable_if_t<std::is_base_of_v<Scene, S>>> {
  using Held = S*;
  static void Send(S& scene, Writer* out) { SendScene(&scene, out); }
  static void Fetch(Reader* in, Held* held) { *held = &dynamic_cast<S&>(*FetchScene(in)); }
  static S& Pass(Held held) { return *held; }
  static void GiveBack(Held, Writer*) {}
  static void TakeBack(Reader*, S&) {}
};
template <typename T>
struct Travel<RemoteObject<T>> {
  using Held = RemoteObject<T>;
  static void Send(const Held& held, Writer* out) {
    *out << held.handle << (held.scene != nullptr);
    if (held.scene) SendScene(held.scene, out);
    *out << ObjectOf<T>::Members(*held.object);
  }
  static void Fetch(Reader* in, Held* held) {
    bool has_scene;
    *in >> held->handle >> has_scene;
    if (has_scene) held->scene = FetchScene(in);
    held->object = Kept<T>(held->handle, held->scene);
    *in >> ObjectOf<T>::Members(*held->object);
  }
  static Held Pass(const Held& held) { return held; }
  static void GiveBack(const Held& held, Writer* out) { *out << ObjectOf<T>::Members(*held.object); }
  static void TakeBack(Reader* in, const Held& held) { *in >> ObjectOf<T>::Members(*held.object); }
};

// ---- the judge's side ------------------------------------------------------------------------------------------------

/// Calls a function of the worker. @return its reply
/// @throws WorkerFailure, WireError, RemoteException (remote.h)
Reader Call(const std::string& function, const Writer& arguments);

template <typename R, typename... A, typename... Given>
R AskAs(R (*)(A...), const std::string& name, Given&&... given) {
  Writer request;
  (Travel<A>::Send(given, &request), ...);
  Reader reply = Call(name, request);
  if constexpr (std::is_void_v<R>) {
    (Travel<A>::TakeBack(&reply, given), ...);
    reply.End();
  } else {
    R result;
    reply >> result;
    (Travel<A>::TakeBack(&reply, given), ...);
    reply.End();
    return result;
  }
}
/// @throws WorkerFailure; WireError if the results do not fit; RemoteException
template <typename F, typename... Given>
auto Ask(Given&&... given) {
  return AskAs(decltype (&F::Run)(nullptr), F::kName, std::forward<Given>(given)...);
}

// ---- the worker's side -----------------------------------------------------------------------------------------------

/// Reads its arguments, calls the student's function, writes its results.
using Handler = void (*)(Reader* in, Writer* out);
/// Before main.
void Handle(const std::string& function, Handler handler);

template <typename R, typename... A>
void AnswerAs(R (*run)(A...), Reader* in, Writer* out) {
  std::tuple<typename Travel<A>::Held...> held;
  std::apply(
      [&](auto&... one) {
        (Travel<A>::Fetch(in, &one), ...);
        if constexpr (std::is_void_v<R>) {
          run(Travel<A>::Pass(one)...);
        } else {
          *out << run(Travel<A>::Pass(one)...);
        }
        (Travel<A>::GiveBack(one, out), ...);
      },
      held);
}
template <typename... F>
void HandleAll() {
  (Handle(F::kName, [](Reader* in, Writer* out) { AnswerAs(&F::Run, in, out); }), ...);
}

}  // namespace ch5::homework
