#pragma once
// The ways to distribute a frame that the simulator compares.

#include "server/lab/schedule_simulator.h"
#include "server/schedule/frame_balance.h"
#include "server/schedule/rate_book.h"

#include <memory>

namespace heliograph {

/// The picture as the simulator sees it.
struct CellGrid {
    uvec2 cells{0, 0};
    uint32_t cellSize = 16;  // pixels
};

/// What the server does: RateBook, chooseParts and FrameBalance; cells from the centre outwards. It knows fixed costs
/// and round trips of the devices, but their rates only from what it has measured.
class OurPolicy : public SchedulePolicy {
public:
    OurPolicy(std::span<const SimulatedDevice> devices, const CellGrid& grid);
    void begin(std::span<const float> predicted, double now) override;
    std::vector<uint32_t> askOrder() const override;
    std::optional<Batch> next(uint32_t worker, double now) override;
    double askAt(uint32_t worker) const override { return balance_.askAt(worker); }
    void deliver(uint32_t cell) override { balance_.deliver(cell); }
    bool finish(const SimulatedResult& result) override;
    bool lose(uint32_t worker) override;
    double nextOverdue() override { return balance_.nextOverdue(); }
    bool checkOverdue(double now) override { return balance_.checkOverdue(now); }
    void endFrame(double now) override;

    std::span<const DevicePart> parts() const { return parts_; }
    const RateBook& rates() const { return rates_; }
    /// Of this machine's time, in FrameBalance: handing out batches and taking note of their ends.
    double decisionSeconds() const { return decisionSeconds_; }

private:
    std::vector<BalanceDevice> devices_;
    std::vector<uint8_t> lost_;  // by device
    std::vector<uint32_t> order_;
    std::vector<DevicePart> parts_;
    RateBook rates_;
    FrameBalance balance_;
    std::vector<float> predicted_;
    double deviation_ = 0.0;
    double decisionSeconds_ = 0.0;
};

/// Every device gets one upright strip of the picture in one piece; a device of several workers shares its strip among
/// them cell by cell. Whole columns of cells.
class StripPolicy : public SchedulePolicy {
public:
    StripPolicy(std::span<const SimulatedDevice> devices, const CellGrid& grid, std::vector<double> shares);
    void begin(std::span<const float> predicted, double now) override;
    std::vector<uint32_t> askOrder() const override;
    std::optional<Batch> next(uint32_t worker, double now) override;

protected:
    std::vector<double> shares_;  // by device, sum 1

private:
    struct Strip {
        uint32_t next = 0, end = 0;
    };  // cells, column by column
    CellGrid grid_;
    std::vector<uint32_t> deviceOf_;
    std::vector<uint32_t> workers_;  // by device
    std::vector<Strip> strips_;
};

/// The same share of columns for each device.
std::unique_ptr<SchedulePolicy> equalSplit(std::span<const SimulatedDevice> devices, const CellGrid& grid);
/// Shares in proportion to the true rates: manual mode by somebody who knows them.
std::unique_ptr<SchedulePolicy> proportionalSplit(std::span<const SimulatedDevice> devices, const CellGrid& grid);
/// The balancer of RayEngine (A. Norgren 2016): from equal shares, after each frame share += 0.25 * (the others' time -
/// own time), in seconds, unless that step is 0.05 or more. For more than two devices: twice the mean time less the
/// own.
std::unique_ptr<SchedulePolicy> rayEngine(std::span<const SimulatedDevice> devices, const CellGrid& grid);
/// Everybody takes the next square of 64x64 pixels from one counter, row by row.
std::unique_ptr<SchedulePolicy> sharedCounter(std::span<const SimulatedDevice> devices, const CellGrid& grid);

}  // namespace heliograph
