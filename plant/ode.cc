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

constexpr int kMostUnrolled = 10;
// Only a runaway right-hand side takes this many steps between two inputs.
constexpr long kMostSteps = 100'000'000;

struct Content {
  explicit Content(int states) : values(static_cast<std::size_t>(states)) {}
  std::vector<double> values;
};

Content& content(N_Vector v) {
  return *static_cast<Content*>(v->content);
}

double* values(N_Vector v) {
  return content(v).values.data();
}

/// The operations ERKStep calls, for vectors of N numbers with the loops unrolled: half the cost of
/// SUNDIALS' serial vector for the handful of states of a drive. N = 0: of any length.
template <int N>
struct Vector {
  static N_Vector create(SUNContext context, int states) {
    const N_Vector v = N_VNewEmpty(context);
    if (v == nullptr) return nullptr;
    v->content = new Content(states);
    _generic_N_Vector_Ops& ops = *v->ops;
    ops.nvgetvectorid = [](N_Vector) { return SUNDIALS_NVEC_CUSTOM; };
    ops.nvclone = clone;
    ops.nvdestroy = destroy;
    ops.nvspace = [](N_Vector x, sunindextype* reals, sunindextype* integers) {
      *reals = size(x);
      *integers = 1;
    };
    ops.nvgetarraypointer = values;
    ops.nvgetlength = [](N_Vector x) { return sunindextype{size(x)}; };
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
      each_index(size(x), [&, a = values(x)](int i) { norm = std::max(norm, std::fabs(a[i])); });
      return norm;
    };
    ops.nvwrmsnorm = weighted_rms;
    ops.nvmin = [](N_Vector x) { return *std::min_element(values(x), values(x) + size(x)); };
    ops.nvlinearcombination = linear_combination;
    return v;
  }

  static int size(N_Vector v) { return N > 0 ? N : static_cast<int>(content(v).values.size()); }

  static N_Vector clone(N_Vector v) { return create(v->sunctx, size(v)); }

  static void destroy(N_Vector v) {
    if (v == nullptr) return;
    delete static_cast<Content*>(v->content);
    v->content = nullptr;
    N_VFreeEmpty(v);
  }

  /// f(0) .. f(size - 1), unrolled if that is known.
  template <class F>
  static void each_index(int size, F&& f) {
    if constexpr (N == 0) {
      for (int i = 0; i < size; ++i) f(i);
    } else {
      [&]<int... I>(std::integer_sequence<int, I...>) {
        (f(I), ...);
      }(std::make_integer_sequence<int, N>{});
    }
  }

  template <class F>
  static void each(N_Vector z, F&& f) {
    double* out = values(z);
    each_index(size(z), [&](int i) { out[i] = f(i); });
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
    each_index(size(x), [&](int i) { sum += a[i] * b[i] * a[i] * b[i]; });
    return std::sqrt(sum / size(x));
  }

  static int linear_combination(int count, double* c, N_Vector* x, N_Vector z) {
    double sum[N > 0 ? N : kMostStates];
    each_index(size(z), [&](int i) { sum[i] = 0; });
    for (int k = 0; k < count; ++k) {
      const double* a = values(x[k]);
      each_index(size(z), [&, factor = c[k]](int i) { sum[i] += factor * a[i]; });
    }
    each(z, [&](int i) { return sum[i]; });
    return 0;
  }
};

using CreateVector = N_Vector (*)(SUNContext, int states);

template <int... N>
CreateVector vector_of(int states, std::integer_sequence<int, N...>) {
  CreateVector create = &Vector<0>::create;
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

  OdeOutcome advance(const Segment& segment, double* x);

  const Problem problem;
  std::uint64_t derivatives = 0;

 private:
  ErkPtr create(bool with_root);
  void require(int flag, const char* call) const;
  OdeOutcome run(void* erk, double* x);
  OdeOutcome run_watched(double* x);

  static int derivative(double, N_Vector x, N_Vector dx, void* self);
  static int root_function(double, N_Vector x, double* g, void* self);
  static int error_weights(N_Vector x, N_Vector weights, void* self);
  static void remember_error(int code, const char* module, const char* function, char* message,
                             void* self);

  Segment segment_;         // during advance()
  double next_step_s_ = 0;  // that the integrator used last would take
  std::string message_;     // SUNDIALS' last error
  ContextPtr context_;
  VectorPtr x_;
  // Two of them because looking for roots costs a quarter of a short step, and a drive that turns
  // has none to look for.
  ErkPtr plain_;
  ErkPtr rooted_;
};

ErkIntegrator::Impl::Impl(const Problem& p) : problem(p) {
  VIRTDRIVE_CHECK(p.states >= 1 && p.states <= kMostStates, "{} states", p.states);
  SUNContext context = nullptr;
  if (SUNContext_Create(nullptr, &context) != 0) {
    throw SetupError("SUNDIALS: no context could be created (out of memory?)");
  }
  context_.reset(context);
  const auto create_vector = vector_of(p.states, std::make_integer_sequence<int, kMostUnrolled>{});
  x_.reset(create_vector(context, p.states));
  plain_ = create(false);
  rooted_ = create(true);
}

ErkPtr ErkIntegrator::Impl::create(bool with_root) {
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
  if (!with_root) {
    // Nothing is interpolated, and the default degree costs a derivative to be ready for it.
    require(ERKStepSetInterpolantDegree(e, 1), "ERKStepSetInterpolantDegree");
  } else {
    int falling = -1;
    require(ERKStepRootInit(e, 1, root_function), "ERKStepRootInit");
    require(ERKStepSetRootDirection(e, &falling), "ERKStepSetRootDirection");
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

OdeOutcome ErkIntegrator::Impl::advance(const Segment& segment, double* x) {
  segment_ = segment;
  if (!segment.watched) return run(plain_.get(), x);
  // The margin is looked at where a step ends. So for a segment of a step or two, and no longer
  // than a step may be, it is enough to look once afterwards, which saves SUNDIALS' bookkeeping.
  if (segment.duration_s > std::min(2 * next_step_s_, segment.longest_step_s)) {
    return run_watched(x);
  }
  double start[kMostStates];
  std::copy_n(x, problem.states, start);
  const OdeOutcome outcome = run(plain_.get(), x);
  if (problem.margin(segment.system, x) > 0) return outcome;
  std::copy_n(start, problem.states, x);
  return run_watched(x);
}

OdeOutcome ErkIntegrator::Impl::run_watched(double* x) {
  OdeOutcome outcome = run(rooted_.get(), x);
  // A margin that reaches 0 right at the end is no crossing to SUNDIALS.
  outcome.event = outcome.event || problem.margin(segment_.system, x) <= 0;
  return outcome;
}

OdeOutcome ErkIntegrator::Impl::run(void* erk, double* x) {
  const double duration_s = segment_.duration_s;
  double* const vector = values(x_.get());
  std::copy_n(x, problem.states, vector);
  // Reset, not ReInit: it forgets the first stage, which Dormand-Prince would take over from the
  // last step and thus from the old inputs (an error of up to 1e-2 that no tolerance shows), and
  // keeps the step size, which is worth a factor of eight.
  require(ERKStepReset(erk, 0, x_.get()), "ERKStepReset");
  require(ERKStepSetStopTime(erk, duration_s), "ERKStepSetStopTime");
  require(ERKStepSetMaxStep(erk, segment_.longest_step_s), "ERKStepSetMaxStep");
  double reached = 0;
  // An output time beyond the stop time: the step ends there, nothing is interpolated.
  const int flag = ERKStepEvolve(erk, 2 * duration_s, x_.get(), &reached, ARK_NORMAL);
  require(flag, "ERKStepEvolve");
  std::copy_n(vector, problem.states, x);
  require(ERKStepGetCurrentStep(erk, &next_step_s_), "ERKStepGetCurrentStep");
  if (flag != ARK_ROOT_RETURN) return {duration_s, false};
  return {std::min(reached, duration_s), true};
}

int ErkIntegrator::Impl::derivative(double, N_Vector x, N_Vector dx, void* self) {
  Impl& impl = *static_cast<Impl*>(self);
  ++impl.derivatives;
  impl.problem.derivative(impl.segment_.system, values(x), values(dx));
  return 0;
}

int ErkIntegrator::Impl::root_function(double, N_Vector x, double* g, void* self) {
  const Impl& impl = *static_cast<Impl*>(self);
  *g = impl.problem.margin(impl.segment_.system, values(x));
  return 0;
}

int ErkIntegrator::Impl::error_weights(N_Vector x, N_Vector weights, void* self) {
  const Impl& impl = *static_cast<Impl*>(self);
  const Segment& s = impl.segment_;
  const double* const state = values(x);
  double* const weight = values(weights);
  for (int i = 0; i < impl.problem.states; ++i) {
    weight[i] = 1 / (s.relative[i] * std::fabs(state[i]) + s.absolute[i]);
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

int ErkIntegrator::states() const {
  return impl_->problem.states;
}

OdeOutcome ErkIntegrator::advance(const Segment& segment, double* x) {
  return impl_->advance(segment, x);
}

std::uint64_t ErkIntegrator::derivative_evaluations() const {
  return impl_->derivatives;
}

}  // namespace virtdrive
