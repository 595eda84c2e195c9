#include "plant/ode.h"

#include <arkode/arkode_erkstep.h>
#include <cstdlib>
#include <string>
#include <sundials/sundials_context.h>
#include <sundials/sundials_nvector.h>
#include <utility>

#include "core/check.h"

namespace virtdrive {
namespace {

constexpr int kMostStates = 8;
constexpr int kMostRoots = 8;
// Only a runaway right-hand side takes this many steps between two inputs.
constexpr long kMostSteps = 100'000'000;

struct Content {
  double values[kMostStates];
};

double* values(N_Vector v) {
  return static_cast<Content*>(v->content)->values;
}

/// The operations ERKStep calls, for vectors of N numbers with the loops unrolled: half the cost of
/// SUNDIALS' serial vector for the handful of states of a drive.
template <int N>
struct Vector {
  static N_Vector create(SUNContext context) {
    const N_Vector v = N_VNewEmpty(context);
    if (v == nullptr) return nullptr;
    v->content = new Content{};
    _generic_N_Vector_Ops& ops = *v->ops;
    ops.nvgetvectorid = [](N_Vector) { return SUNDIALS_NVEC_CUSTOM; };
    ops.nvclone = clone;
    ops.nvdestroy = destroy;
    ops.nvspace = [](N_Vector, sunindextype* reals, sunindextype* integers) {
      *reals = N;
      *integers = 1;
    };
    ops.nvgetarraypointer = values;
    ops.nvgetlength = [](N_Vector) { return sunindextype{N}; };
    ops.nvlinearsum = linear_sum;
    ops.nvconst = [](double c, N_Vector z) { each(z, [&](int) { return c; }); };
    ops.nvprod = [](N_Vector x, N_Vector y, N_Vector z) {
      each(z, [a = values(x), b = values(y)](int i) { return a[i] * b[i]; });
    };
    ops.nvdiv = [](N_Vector x, N_Vector y, N_Vector z) {
      each(z, [a = values(x), b = values(y)](int i) { return a[i] / b[i]; });
    };
    ops.nvscale = scale;
    ops.nvabs = [](N_Vector x, N_Vector z) {
      each(z, [a = values(x)](int i) { return std::fabs(a[i]); });
    };
    ops.nvinv = [](N_Vector x, N_Vector z) {
      each(z, [a = values(x)](int i) { return 1 / a[i]; });
    };
    ops.nvaddconst = [](N_Vector x, double b, N_Vector z) {
      each(z, [a = values(x), b](int i) { return a[i] + b; });
    };
    ops.nvmaxnorm = [](N_Vector x) {
      double norm = 0;
      each_index([&, a = values(x)](int i) { norm = std::max(norm, std::fabs(a[i])); });
      return norm;
    };
    ops.nvwrmsnorm = weighted_rms;
    ops.nvmin = [](N_Vector x) { return *std::min_element(values(x), values(x) + N); };
    ops.nvlinearcombination = linear_combination;
    return v;
  }

  static N_Vector clone(N_Vector v) { return create(v->sunctx); }

  static void destroy(N_Vector v) {
    if (v == nullptr) return;
    delete static_cast<Content*>(v->content);
    v->content = nullptr;
    N_VFreeEmpty(v);
  }

  /// f(0) .. f(N - 1), unrolled.
  template <class F>
  static void each_index(F&& f) {
    [&]<int... I>(std::integer_sequence<int, I...>) {
      (f(I), ...);
    }(std::make_integer_sequence<int, N>{});
  }

  template <class F>
  static void each(N_Vector z, F&& f) {
    double* out = values(z);
    each_index([&](int i) { out[i] = f(i); });
  }

  static void scale(double c, N_Vector x, N_Vector z) {
    each(z, [a = values(x), c](int i) { return c * a[i]; });
  }

  static void linear_sum(double a, N_Vector x, double b, N_Vector y, N_Vector z) {
    each(z, [=, u = values(x), v = values(y)](int i) { return a * u[i] + b * v[i]; });
  }

  static double weighted_rms(N_Vector x, N_Vector w) {
    const double *a = values(x), *b = values(w);
    double sum = 0;
    each_index([&](int i) { sum += a[i] * b[i] * a[i] * b[i]; });
    return std::sqrt(sum / N);
  }

  static int linear_combination(int count, double* c, N_Vector* x, N_Vector z) {
    double sum[N] = {};
    for (int k = 0; k < count; ++k) {
      const double* a = values(x[k]);
      each_index([&, factor = c[k]](int i) { sum[i] += factor * a[i]; });
    }
    each(z, [&](int i) { return sum[i]; });
    return 0;
  }
};

using CreateVector = N_Vector (*)(SUNContext);

template <int... N>
CreateVector vector_of(int states, std::integer_sequence<int, N...>) {
  CreateVector create = nullptr;
  ((states == N + 1 ? void(create = &Vector<N + 1>::create) : void()), ...);
  return create;
}

struct ContextDeleter {
  void operator()(SUNContext context) const { SUNContext_Free(&context); }
};
struct VectorDeleter {
  void operator()(N_Vector v) const { N_VDestroy(v); }
};
struct ErkDeleter {
  void operator()(void* erk) const { ERKStepFree(&erk); }
};
using ContextPtr = std::unique_ptr<std::remove_pointer_t<SUNContext>, ContextDeleter>;
using VectorPtr = std::unique_ptr<std::remove_pointer_t<N_Vector>, VectorDeleter>;
using ErkPtr = std::unique_ptr<void, ErkDeleter>;

}  // namespace

struct ErkIntegrator::Impl {
  explicit Impl(const Problem& p);

  OdeOutcome advance(const void* with, double* x, double duration_s, bool watched,
                     double longest_step_s);

 private:
  ErkPtr create(bool with_roots);
  void require(int flag, const char* call) const;
  OdeOutcome run(void* erk, double* x, double duration_s);
  OdeOutcome run_watched(double* x, double duration_s);
  bool any_root_down(const double* x) const;
  std::uint32_t roots_below_zero(const double* x) const;

  static int derivative(double, N_Vector x, N_Vector dx, void* self);
  static int root_functions(double, N_Vector x, double* g, void* self);
  static int error_weights(N_Vector x, N_Vector weights, void* self);
  static void remember_error(int code, const char* module, const char* function, char* message,
                             void* self);

  Problem problem_;
  double relative_[kMostStates] = {};
  double absolute_[kMostStates] = {};
  const void* system_ = nullptr;  // during advance()
  double longest_step_s_ = 0;
  double next_step_s_ = 0;  // that the integrator used last would take
  std::string message_;     // SUNDIALS' last error
  ContextPtr context_;
  VectorPtr x_;
  // Two of them because looking for roots costs a quarter of a short step, and a drive that turns
  // has none to look for.
  ErkPtr plain_;
  ErkPtr rooted_;

 public:
  std::uint64_t derivatives = 0;
};

ErkIntegrator::Impl::Impl(const Problem& p) : problem_(p) {
  VIRTDRIVE_CHECK(p.states >= 1 && p.states <= kMostStates, "{} states", p.states);
  VIRTDRIVE_CHECK(p.roots >= 0 && p.roots <= kMostRoots, "{} roots", p.roots);
  std::copy_n(p.relative, p.states, relative_);
  std::copy_n(p.absolute, p.states, absolute_);
  problem_.relative = problem_.absolute = nullptr;  // the caller's
  SUNContext context = nullptr;
  if (SUNContext_Create(nullptr, &context) != 0) {
    throw SetupError("SUNDIALS: no context could be created (out of memory?)");
  }
  context_.reset(context);
  const auto create_vector = vector_of(p.states, std::make_integer_sequence<int, kMostStates>{});
  x_.reset(create_vector(context));
  plain_ = create(false);
  if (p.roots > 0) rooted_ = create(true);
}

ErkPtr ErkIntegrator::Impl::create(bool with_roots) {
  ErkPtr erk(ERKStepCreate(derivative, 0, x_.get(), context_.get()));
  if (!erk) throw SetupError("SUNDIALS: ERKStepCreate failed");
  void* const e = erk.get();
  require(ERKStepSetErrHandlerFn(e, remember_error, this), "ERKStepSetErrHandlerFn");
  require(ERKStepSetUserData(e, this), "ERKStepSetUserData");
  // Named: the default table changed between releases of SUNDIALS.
  require(ERKStepSetTableNum(e, ARKODE_DORMAND_PRINCE_7_4_5), "ERKStepSetTableNum");
  require(ERKStepWFtolerances(e, error_weights), "ERKStepWFtolerances");
  require(ERKStepSetMaxNumSteps(e, kMostSteps), "ERKStepSetMaxNumSteps");
  require(ERKStepSetMaxHnilWarns(e, -1), "ERKStepSetMaxHnilWarns");
  if (!with_roots) {
    // Nothing is interpolated, and the default degree costs a derivative to be ready for it.
    require(ERKStepSetInterpolantDegree(e, 1), "ERKStepSetInterpolantDegree");
  } else {
    require(ERKStepRootInit(e, problem_.roots, root_functions), "ERKStepRootInit");
    int falling[kMostRoots];
    std::fill_n(falling, kMostRoots, -1);
    require(ERKStepSetRootDirection(e, falling), "ERKStepSetRootDirection");
    require(ERKStepSetNoInactiveRootWarn(e), "ERKStepSetNoInactiveRootWarn");
  }
  return erk;
}

void ErkIntegrator::Impl::require(int flag, const char* call) const {
  if (flag >= 0) return;
  char* const name = ERKStepGetReturnFlagName(flag);
  const std::string text = fmt::format("SUNDIALS: {} failed with {}{}{}", call, name,
                                       message_.empty() ? "" : ": ", message_);
  std::free(name);
  throw SetupError(text);
}

OdeOutcome ErkIntegrator::Impl::advance(const void* with, double* x, double duration_s,
                                        bool watched, double longest_step_s) {
  system_ = with;
  longest_step_s_ = longest_step_s;
  if (!watched) return run(plain_.get(), x, duration_s);
  // Root functions are looked at where a step ends. So for a segment of a step or two it is enough
  // to look once afterwards, which saves SUNDIALS' bookkeeping.
  if (duration_s > 2 * next_step_s_) return run_watched(x, duration_s);
  double start[kMostStates];
  std::copy_n(x, problem_.states, start);
  const OdeOutcome outcome = run(plain_.get(), x, duration_s);
  if (!any_root_down(x)) return outcome;
  std::copy_n(start, problem_.states, x);
  return run_watched(x, duration_s);
}

OdeOutcome ErkIntegrator::Impl::run_watched(double* x, double duration_s) {
  OdeOutcome outcome = run(rooted_.get(), x, duration_s);
  // A root that starts at exactly 0 and goes the wrong way is no crossing to SUNDIALS.
  if (outcome.fired == 0) outcome.fired = roots_below_zero(x);
  return outcome;
}

bool ErkIntegrator::Impl::any_root_down(const double* x) const {
  double g[kMostRoots];
  problem_.root_functions(system_, x, g);
  return std::any_of(g, g + problem_.roots, [](double value) { return value <= 0; });
}

std::uint32_t ErkIntegrator::Impl::roots_below_zero(const double* x) const {
  double g[kMostRoots];
  problem_.root_functions(system_, x, g);
  std::uint32_t bits = 0;
  for (int i = 0; i < problem_.roots; ++i) bits |= g[i] < 0 ? 1U << i : 0;
  return bits;
}

OdeOutcome ErkIntegrator::Impl::run(void* erk, double* x, double duration_s) {
  double* const vector = values(x_.get());
  std::copy_n(x, problem_.states, vector);
  // Reset, not ReInit: it forgets the first stage, which Dormand-Prince would take over from the
  // last step and thus from the old inputs (an error of up to 1e-2 that no tolerance shows), and
  // keeps the step size, which is worth a factor of eight.
  require(ERKStepReset(erk, 0, x_.get()), "ERKStepReset");
  require(ERKStepSetStopTime(erk, duration_s), "ERKStepSetStopTime");
  require(ERKStepSetMaxStep(erk, longest_step_s_), "ERKStepSetMaxStep");
  double reached = 0;
  // An output time beyond the stop time: the step ends there, nothing is interpolated.
  const int flag = ERKStepEvolve(erk, 2 * duration_s, x_.get(), &reached, ARK_NORMAL);
  require(flag, "ERKStepEvolve");
  std::copy_n(vector, problem_.states, x);
  require(ERKStepGetCurrentStep(erk, &next_step_s_), "ERKStepGetCurrentStep");
  if (flag != ARK_ROOT_RETURN) return {duration_s, 0};
  int info[kMostRoots] = {};
  require(ERKStepGetRootInfo(erk, info), "ERKStepGetRootInfo");
  std::uint32_t fired = 0;
  for (int i = 0; i < problem_.roots; ++i) {
    if (info[i] != 0) fired |= 1U << i;
  }
  return {std::min(reached, duration_s), fired};
}

int ErkIntegrator::Impl::derivative(double, N_Vector x, N_Vector dx, void* self) {
  Impl& impl = *static_cast<Impl*>(self);
  ++impl.derivatives;
  impl.problem_.derivative(impl.system_, values(x), values(dx));
  return 0;
}

int ErkIntegrator::Impl::root_functions(double, N_Vector x, double* g, void* self) {
  const Impl& impl = *static_cast<Impl*>(self);
  impl.problem_.root_functions(impl.system_, values(x), g);
  return 0;
}

int ErkIntegrator::Impl::error_weights(N_Vector x, N_Vector weights, void* self) {
  const Impl& impl = *static_cast<Impl*>(self);
  for (int i = 0; i < impl.problem_.states; ++i) {
    values(weights)[i] = 1 / (impl.relative_[i] * std::fabs(values(x)[i]) + impl.absolute_[i]);
  }
  return 0;
}

void ErkIntegrator::Impl::remember_error(int, const char*, const char*, char* message, void* self) {
  static_cast<Impl*>(self)->message_ = message;
}

ErkIntegrator::ErkIntegrator(const Problem& problem) : impl_(std::make_unique<Impl>(problem)) {}
ErkIntegrator::ErkIntegrator(ErkIntegrator&&) noexcept = default;
ErkIntegrator& ErkIntegrator::operator=(ErkIntegrator&&) noexcept = default;
ErkIntegrator::~ErkIntegrator() = default;

OdeOutcome ErkIntegrator::advance(const void* system, double* x, double duration_s, bool watched,
                                  double longest_step_s) {
  return impl_->advance(system, x, duration_s, watched, longest_step_s);
}

std::uint64_t ErkIntegrator::derivative_evaluations() const {
  return impl_->derivatives;
}

}  // namespace virtdrive
