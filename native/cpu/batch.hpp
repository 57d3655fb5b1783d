// A batch of simulations on a pool of threads: each thread takes the next one when it is done with the last, longest expected first.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "graincal/engines.hpp"
#include "owned_simulation.hpp"
#include "targets.hpp"

namespace graincal {

template <class Engine> struct Task {
    OwnedSimulation<typename Engine::Real, typename Engine::Law> simulation;
    std::vector<Stage> stages;
    Rest rest;
    long long step_limit;  // of the whole run; more ends it
};

struct Outcome {
    Index task;
    Status status;
    bool consolidation_flagged;
    std::vector<Record> records;
    long long steps;
    double seconds;
};

class Batch {
  public:
    // Looks at a task's records each time that there is one more, on the thread that runs it: true to stop the run. It throws nothing but std::bad_alloc.
    using Watch = std::function<bool(Index task, std::span<const Record> records)>;

    // `make(i)` builds the i-th task, of any engine, on the thread that will run it, so that only simulations under way take memory.
    // `order` lists the tasks in the order in which they start.
    template <class Make>
    Batch(Make make, std::vector<Index> order, unsigned threads, const Target& target, Watch watch = {})
        : order_(std::move(order)), target_(target), watch_(std::move(watch)) {
        for (unsigned t = 0; t < threads; ++t)
            threads_.emplace_back([this, make] {
                for (std::size_t k; (k = next_++) < order_.size();) deliver(outcome_of(order_[k], make));
            });
    }
    ~Batch() { finish(); }

    // Ends what is under way, and waits for that.
    void finish() {
        cancel();
        for (auto& thread : threads_) thread.join();
        threads_.clear();
    }

    // The next outcome in order of completion; nothing if none comes within the time.
    std::optional<Outcome> next(std::chrono::duration<double> patience) {
        std::unique_lock lock(mutex_);
        if (!arrived_.wait_for(lock, patience, [&] { return !done_.empty(); })) return std::nullopt;
        Outcome outcome = std::move(done_.front());
        done_.pop_front();
        return outcome;
    }
    void cancel() { cancelled_ = true; }

  private:
    static constexpr long long steps_between_looks = 50;

    template <class Make> Outcome outcome_of(Index index, Make& make) {
        if (cancelled_) return {index, Status::cancelled, false, {}, 0, 0};
        try {
            return run(index, make(index));
        } catch (const std::bad_alloc&) {
            return {index, Status::out_of_memory, false, {}, 0, 0};
        }
    }

    template <class Engine> Outcome run(Index index, Task<Engine> task) {
        const auto start = std::chrono::steady_clock::now();
        auto& state = task.simulation.state;
        Progress progress;
        std::vector<Record> records(task.stages.size());
        Index watched = 0;
        enter_stage(task.stages[0], state, progress, task.rest);
        Status status = Status::running;
        while (status == Status::running) {
            if (cancelled_)
                status = Status::cancelled;
            else if (state.steps >= task.step_limit)
                status = Status::out_of_steps;
            else if (watch_ && progress.records > watched && watch_(index, std::span(records).first(watched = progress.records)))
                status = Status::stopped;
            else
                status = task.simulation.advance([&] {
                    return static_cast<Status>(target_.follow({CompiledEngines::index<Engine>(), &state, task.stages.data(),
                                                               static_cast<Index>(task.stages.size()), &progress, &task.rest, records.data(),
                                                               steps_between_looks}));
                });
        }
        records.resize(progress.records);
        const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
        return {index, status, progress.consolidation_flagged, std::move(records), task.simulation.state.steps, elapsed.count()};
    }

    void deliver(Outcome outcome) {
        {
            std::lock_guard lock(mutex_);
            done_.push_back(std::move(outcome));
        }
        arrived_.notify_one();
    }

    std::vector<Index> order_;
    const Target& target_;
    Watch watch_;
    std::atomic<std::size_t> next_{0};
    std::atomic<bool> cancelled_{false};
    std::mutex mutex_;
    std::condition_variable arrived_;
    std::deque<Outcome> done_;
    std::vector<std::thread> threads_;
};

}  // namespace graincal
