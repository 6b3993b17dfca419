// Gathers elements from all ranks repeatedly, usually with one exchange each time. In this
// exchange, each rank sends a header, which contains its number of elements, and as many elements
// as there is room for. The room of a rank is nine eighths of the number of its elements in the
// previous gather; in the first gather, it is 0. A second exchange sends the remaining elements, if
// there are any.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <utility>
#include <vector>

#include "core/parallel/shared_work.h"

namespace loomstone {

// Room of each rank in the next gather. Every kind of element needs its own GatherRoom.
struct GatherRoom {
  std::vector<std::size_t> elements;  // (ranks) number of elements
  std::vector<std::byte> buffer;      // scratch
};

// Elements of all ranks, and a note (one additional value) of each rank.
template <class Element, class Note>
struct NotedGather {
  Gathered<Element> gathered;
  std::vector<Note> notes;  // (ranks)
};

namespace detail {

template <class Element, class Note>
class GatherOnce {
 public:
  GatherOnce(const Communicator& ranks, GatherRoom& room)
      : ranks_(ranks), room_(room), headers_(ranks.size()) {
    room_.elements.resize(ranks.size(), 0);
  }

  template <class Work>
  NotedGather<Element, Note> run(Work&& work) {
    Header& own = headers_[ranks_.rank()];
    std::vector<Element> elements;
    std::exception_ptr failure;
    try {
      elements = work(own.note);
    } catch (...) {
      failure = std::current_exception();
      elements.clear();
      own.failed = 1;
    }
    own.size = elements.size();
    send_first(elements);
    const auto failed = [](const Header& header) { return header.failed != 0; };
    if (std::any_of(headers_.begin(), headers_.end(), failed)) agree_on(ranks_, failure);
    NotedGather<Element, Note> all;
    join(send_rest(elements), all.gathered);
    for (int rank = 0; rank < ranks_.size(); ++rank) {
      all.notes.push_back(headers_[rank].note);
      room_.elements[rank] = headers_[rank].size + headers_[rank].size / 8;
    }
    return all;
  }

 private:
  struct Header {
    std::size_t failed = 0, size = 0;
    Note note{};
  };
  // The elements of a rank follow its header in the buffer, where they must be aligned.
  static_assert(sizeof(Header) % alignof(Element) == 0);

  std::size_t n_first(int rank) const {
    return std::min(room_.elements[rank], headers_[rank].size);
  }

  // Exchanges all headers and the elements for which there is room.
  void send_first(const std::vector<Element>& elements) {
    const int own = ranks_.rank();
    offsets_ = {0};
    for (const std::size_t room : room_.elements)
      offsets_.push_back(offsets_.back() + sizeof(Header) + room * sizeof(Element));
    room_.buffer.resize(offsets_.back());
    copy(&headers_[own], 1, at(own));
    copy(elements.data(), n_first(own), at(own) + sizeof(Header));
    ranks_.gather_all(room_.buffer.data(), offsets_);
    for (int rank = 0; rank < ranks_.size(); ++rank)
      std::memcpy(static_cast<void*>(&headers_[rank]), at(rank), sizeof(Header));
  }

  // Exchanges the elements for which there was no room, and returns those of all ranks.
  Gathered<Element> send_rest(const std::vector<Element>& elements) const {
    Gathered<Element> rest;
    rest.start = {0};
    std::vector<std::size_t> offsets = {0};
    for (int rank = 0; rank < ranks_.size(); ++rank) {
      rest.start.push_back(rest.start.back() + headers_[rank].size - n_first(rank));
      offsets.push_back(sizeof(Element) * rest.start.back());
    }
    if (rest.start.back() == 0) return rest;
    const int own = ranks_.rank();
    rest.elements.resize(rest.start.back());
    std::copy(elements.begin() + static_cast<std::ptrdiff_t>(n_first(own)), elements.end(),
              rest.elements.begin() + static_cast<std::ptrdiff_t>(rest.start[own]));
    ranks_.gather_all(rest.elements.data(), offsets);
    return rest;
  }

  // Joins the elements of both exchanges.
  void join(const Gathered<Element>& rest, Gathered<Element>& all) {
    all.start = {0};
    for (const Header& header : headers_) all.start.push_back(all.start.back() + header.size);
    all.elements.reserve(all.start.back());
    const auto append = [&](const Element* from, std::size_t n) {
      all.elements.insert(all.elements.end(), from, from + n);
    };
    for (int rank = 0; rank < ranks_.size(); ++rank) {
      append(reinterpret_cast<const Element*>(at(rank) + sizeof(Header)), n_first(rank));
      const std::size_t begin = rest.start[rank];
      append(rest.elements.data() + begin, rest.start[rank + 1] - begin);
    }
  }

  std::byte* at(int rank) { return room_.buffer.data() + offsets_[rank]; }
  template <class Type>
  static void copy(const Type* from, std::size_t n, std::byte* to) {
    // Vectors of Eigen have no trivial copy constructor, but consist of their numbers only.
    if (n > 0) std::memcpy(to, static_cast<const void*>(from), n * sizeof(Type));
  }

  const Communicator& ranks_;
  GatherRoom& room_;
  std::vector<Header> headers_;
  std::vector<std::size_t> offsets_;
};

}  // namespace detail

// Collective. Returns the elements and notes of all ranks. `work(note)` returns the elements of
// this rank and sets its note. Elements and notes are copied byte by byte. If the work fails on
// some ranks, all ranks throw the error of the lowest of these ranks.
template <class Element, class Note, class Work>
NotedGather<Element, Note> gather_again(const Communicator& ranks, GatherRoom& room, Work&& work) {
  if (ranks.size() > 1) return detail::GatherOnce<Element, Note>(ranks, room).run(work);
  NotedGather<Element, Note> all;
  all.notes.resize(1);
  all.gathered.elements = work(all.notes.front());
  all.gathered.start = {0, all.gathered.elements.size()};
  return all;
}

}  // namespace loomstone
