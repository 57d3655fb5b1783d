// A batch of simulations on a pool of threads: each thread takes the next one when it is done with the last, longest expected first.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
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
    // Looks at a task's records each time that there is one more, on the thread that runs it: true to stop the run.
    using Watch = std::function<bool(Index task, std::span<const Record> records)>;

    // `make(i)` builds the i-th task, of any engine, on the thread that will run it, so that only simulations under way take memory.
    // `order` lists the tasks in the order in which they start. Throws std::runtime_error where not all of the threads can be started.
    template <class Make>
    Batch(Make make, std::vector<Index> order, unsigned threads, const Target& target, Watch watch = {})
        : order_(std::move(order)), target_(target), watch_(std::move(watch)) {
        const auto shared = std::make_shared<const Make>(std::move(make));
        try {
            while (threads_.size() < threads) threads_.emplace_back([this, shared] { work(*shared); });
        } catch (const std::system_error& error) {
            const std::string started = std::to_string(threads_.size());
            finish();
            throw std::runtime_error("only " + started + " of " + std::to_string(threads) + " threads could be started (" + error.code().message() + ")");
        } catch (...) {
            finish();
            throw;
        }
    }
    ~Batch() { finish(); }

    // Ends what is under way, and waits for that.
    void finish() {
        cancel();
        for (auto& thread : threads_) thread.join();
        threads_.clear();
    }

    // The next outcome in order of completion; nothing if none comes within the time. A task that throws has none: the first exception is thrown here
    // instead, and the other tasks are cancelled. Want of memory for a simulation is an outcome.
    std::optional<Outcome> next(std::chrono::duration<double> patience) {
        std::unique_lock lock(mutex_);
        arrived_.wait_for(lock, patience, [&] { return thrown_ || !done_.empty(); });
        if (thrown_) std::rethrow_exception(std::exchange(thrown_, nullptr));
        if (done_.empty()) return std::nullopt;
        Outcome outcome = std::move(done_.front());
        done_.pop_front();
        return outcome;
    }
    void cancel() { cancelled_ = true; }

  private:
    static constexpr long long steps_between_looks = 50;

    template <class Make> void work(const Make& make) noexcept {
        for (std::size_t k; (k = next_++) < order_.size();) {
            try {
                deliver(outcome_of(order_[k], make));
            } catch (...) {
                fail(std::current_exception());
            }
        }
    }

    template <class Make> Outcome outcome_of(Index index, const Make& make) {
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
                    return static_cast<Status>(
                        target_.follow({CompiledEngines::index<Engine>(), &state, task.stages.data(), static_cast<Index>(task.stages.size()), &progress,
                                        &task.rest, records.data(), steps_between_looks}));
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

    void fail(std::exception_ptr error) {
        cancel();
        {
            std::lock_guard lock(mutex_);
            if (!thrown_) thrown_ = std::move(error);
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
    std::exception_ptr thrown_;
    std::vector<std::thread> threads_;
};

}  // namespace graincal
