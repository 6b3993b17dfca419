#include "core/sim/scene/scene_digest.h"

#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstdio>
#include <type_traits>

#include "core/base/choice.h"
#include "core/base/error.h"
#include "core/base/message.h"
#include "core/base/word_hash.h"
#include "core/parallel/shared_work.h"

namespace loomstone {

namespace {

template <class T>
concept Description = requires { T::fields(); };

class Digest {
 public:
  void add(double value) {
    constexpr double nothing = 1e-12;
    word(std::abs(value) < nothing ? 0 : std::bit_cast<std::uint32_t>(static_cast<float>(value)));
  }
  template <std::integral T>
  void add(T value) {
    word(static_cast<std::uint64_t>(value));
  }
  void add(const std::string& text) {
    word(text.size());
    for (const char letter : text) word(static_cast<unsigned char>(letter));
  }
  template <Choice Enum>
  void add(Enum value) {
    add(std::string(name_of(value)));
  }
  template <class Derived>
  void add(const Eigen::MatrixBase<Derived>& matrix) {
    word(static_cast<std::uint64_t>(matrix.rows()));
    for (Eigen::Index i = 0; i < matrix.size(); ++i) add(matrix.derived().data()[i]);
  }
  void add(const std::shared_ptr<const TriangleMesh>& mesh) {
    word(mesh != nullptr);
    if (mesh)
      add(mesh->vertices()), add(mesh->triangles()), add(mesh->uv()), add(mesh->uv_triangles());
  }
  void add(const SourceRecipe& recipe) {
    add(recipe.kind);
    for (const auto& [name, value] : recipe.values)
      add(name), std::visit([&](const auto& v) { add(v); }, value);
    add(recipe.mesh);
    word(recipe.of != nullptr);
    if (recipe.of) add(*recipe.of);
  }
  void add(const RigidPose& pose) { add(pose.position), add(pose.orientation); }
  void add(const MagneticBody& body) { add(body.source->recipe()), add(body.pose); }
  void add(const SoftBody& body) {
    add(body.shape->recipe()), add(body.pose), add(body.saturation);
  }
  void add(const MagnetSource& source) {
    word(source.index());
    if (const auto* hard = std::get_if<MagneticBody>(&source)) add(*hard);
    if (const auto* soft = std::get_if<SoftBody>(&source)) add(*soft);
  }
  void add(const std::optional<Look>&) {}  // does not affect the simulation
  void add(const Automatic& value) { add(value.given); }
  template <class T>
  void add(const std::optional<T>& value) {
    word(value.has_value());
    if (value) add(*value);
  }
  template <class T>
  void add(const std::vector<T>& values) {
    word(values.size());
    for (const T& value : values) add(value);
  }
  // Hashes only fields that differ from their defaults, so that adding a field to a description
  // does not change the hashes of scenes that do not use it.
  template <Description D>
  void add(const D& description) {
    visit(description,
          [&](const char* name, std::uint64_t sum) { add(std::string(name)), word(sum); });
  }

  template <Description D, class Visitor>
  static void visit(const D& description, Visitor&& visitor) {
    D defaults;  // not D{}, whose strings GCC 12 reports as uninitialised
    for_each_field<D>([&](const auto& each) {
      Digest given, usual;
      given.add(description.*(each.member)), usual.add(defaults.*(each.member));
      if (given.hash_.sum != usual.hash_.sum) visitor(each.name, given.hash_.sum);
    });
  }
  std::uint64_t sum() const { return hash_.sum; }

 private:
  void word(std::uint64_t value) { hash_.add(value); }
  WordHash hash_;
};

using Digests = std::map<std::string, std::string>;

// Returns the names of the fields whose digests differ, joined by commas.
std::string differing(const Digests& one, const Digests& other) {
  std::string differ;
  const auto note = [&](const std::string& name) { differ += (differ.empty() ? "" : ", ") + name; };
  for (const auto& [name, digest] : one)
    if (const auto found = other.find(name); found == other.end() || found->second != digest)
      note(name);
  for (const auto& [name, digest] : other)
    if (!one.count(name)) note(name);
  return differ;
}

}  // namespace

Digests digests(const Scene& scene, const IntegratorOptions& options) {
  Digests all;
  const auto note = [&](const std::string& whose) {
    return [&all, whose](const char* name, std::uint64_t sum) {
      char text[17];
      std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(sum));
      all[whose + name] = text;
    };
  };
  Digest::visit(scene, note("scene."));
  options.visit([&](const auto& method) {
    Digest name, usual;
    name.add(std::string(method.name)), usual.add(std::string(SemiImplicitEuler::name));
    if (name.sum() != usual.sum()) note("integrator.")("method", name.sum());
    Digest::visit(method, note("integrator."));
  });
  return all;
}

void check_same_on_ranks(const Communicator& ranks, const Digests& digests) {
  if (ranks.size() == 1) return;
  const Gathered<char> all = gather_from_ranks(ranks, [&] {
    std::vector<char> text;
    for (const auto& [name, digest] : digests)
      for (const std::string& word : {name, digest})
        text.insert(text.end(), word.c_str(), word.c_str() + word.size() + 1);
    return text;
  });
  const auto digests_of = [&](int rank) {
    Digests found;
    const char* next = all.elements.data() + all.start[rank];
    const char* const end = all.elements.data() + all.start[rank + 1];
    while (next < end) {
      const std::string name = next, digest = next + name.size() + 1;
      next += name.size() + digest.size() + 2;
      found[name] = digest;
    }
    return found;
  };
  const Digests first = digests_of(0);
  for (int rank = 1; rank < ranks.size(); ++rank)
    if (const std::string differ = differing(first, digests_of(rank)); !differ.empty())
      fail<InvalidInput>(
          "all ranks must be given the same scene and integrator, but those of rank {} differ from "
          "those of rank 0 in {}; do not let them depend on the rank, on the time or on random "
          "numbers without a seed",
          rank, differ);
}

void check_digests(const Digests& kept, const Digests& now) {
  if (kept.empty()) return;
  const std::string differ = differing(kept, now);
  if (differ.empty()) return;
  throw CacheError("the checkpoint is of another scene or integrator (these differ: " + differ +
                   "); continue with the scene and integrator of the run, or begin a new run from "
                   "its last positions "
                   "and velocities");
}

}  // namespace loomstone
