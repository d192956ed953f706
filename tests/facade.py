"""Private names that tests need, each once, by the room it stands in: who moves a module changes this file alone."""

from functools import partial

from sdaeverify.api import SettingsOptions, plan_of, result_of, settings_from
from sdaeverify.cli.codes_of_runs import code_of_gate
from sdaeverify.cli.exit_codes import ExitCode
from sdaeverify.cli.program import conclude, execute, sdaeverify
from sdaeverify.conformance.contract import (
    contract_violation,
    trials,
    uses_declared_noise,
)
from sdaeverify.conformance.exactness import exactness_violation as _exactness_violation
from sdaeverify.conformance.exactness import law_error
from sdaeverify.conformance.own_numbers import draws_own_numbers
from sdaeverify.conformance.trial import Trial
from sdaeverify.conformance.violation import LAW, departure
from sdaeverify.conformance.violation import violation as _violation
from sdaeverify.contracts.finding import CONDITIONS, Status
from sdaeverify.contracts.labels import (
    REQUIRED,
    Label,
    Parameter,
    dataclass_parameters,
    make_label,
    matches,
    parse_label,
    read_values,
    split_list,
)
from sdaeverify.contracts.matching import match
from sdaeverify.contracts.measure import followed_by, rests_on_moments
from sdaeverify.contracts.opened import home_of, openings
from sdaeverify.contracts.scheme import flatten, same_kind, with_claims
from sdaeverify.contracts.specs import ProblemSpec, check_problem_function, function_parameters, problem_spec
from sdaeverify.contracts.spelling import did_you_mean
from sdaeverify.contracts.stages import FIRST_BLOCK, SCREENING
from sdaeverify.contracts.tally import largest
from sdaeverify.errors import FAULTS, MissingLibraryError, one_line
from sdaeverify.forms import Delayed, IndexOne, Mesh, components, known_traits
from sdaeverify.forms.delay.partials import partials
from sdaeverify.forms.delay.universal import IndexOneTrees
from sdaeverify.forms.generic import GenericClass, Polynomial, draw_polynomial, draw_regular, monomials_of
from sdaeverify.forms.sde.linear_growth import grows_linearly
from sdaeverify.forms.trees.far_problems import TIME_0, placements
from sdaeverify.forms.trivial import H
from sdaeverify.gate.expected import FailingClaim
from sdaeverify.gate.gate_plan import gate_plan
from sdaeverify.gate.github import (
    MOST,
    annotations,
    data_text,
    fence,
    markdown_report,
    property_text,
    source_in,
)
from sdaeverify.gate.lock import (
    Key,
    Locked,
    compare,
    found_claims,
    lock_text,
    locked_tiers,
    read_lock,
    restrict,
    undecided_claims,
    write_lock,
)
from sdaeverify.gate.outcomes import idle, outcomes, why_never
from sdaeverify.gate.policy import Policy, read_policy
from sdaeverify.gate.tiers import TIERS, seed_of
from sdaeverify.measures.drift import EDGES, Drift, ResidualObserver, _classify, log_spaced, quadrature, quantile
from sdaeverify.measures.invariant import (
    CHAINS,
    OPERATOR,
    Invariant,
    operator_findings,
    operator_orders,
    stationary_record,
)
from sdaeverify.measures.invariant.chain_order import BiasSample, exceeds
from sdaeverify.measures.means import MeanObserver, means_of
from sdaeverify.measures.path_errors import order as path_order
from sdaeverify.measures.path_errors.consistency import consistency_opinions, judge_departure, probe_consistency
from sdaeverify.measures.path_errors.errors import ErrorObserver, tally_errors
from sdaeverify.measures.path_errors.quantity import level_rows, quantities_of
from sdaeverify.measures.resolution import (
    bound_limit_error,
    stationary_resolution,
    step_resolution,
    strong_resolution,
    weak_resolution,
)
from sdaeverify.measures.stability import Stability
from sdaeverify.measures.strong import Strong
from sdaeverify.measures.strong import findings as strong_findings
from sdaeverify.measures.strong.findings import FIRST, SECOND, WHOLE, judge_order, judge_strong
from sdaeverify.measures.strong.members import member_findings, step_findings
from sdaeverify.measures.weak import CHANGES_SIGN, ROUNDING, TOO_FEW, Weak, mean_order
from sdaeverify.measures.weak.probe import judge_probe, judge_weak, probe_weak
from sdaeverify.noise.areas import join_areas, known_part, outer, pairs
from sdaeverify.noise.brownian import LONGEST, Brownian, fingerprint
from sdaeverify.numerics.derivatives import jacobian_at_once
from sdaeverify.numerics.digits import LAST_BITS, SAMPLED, keep_defined, significant
from sdaeverify.numerics.linalg import all_finite, eliminated
from sdaeverify.numerics.statistics import (
    EPS,
    chernoff_interval,
    correct_for_skewness,
    corrected_slope_weights,
    leave_out,
    log_functional,
    lower_term_weights,
)
from sdaeverify.probe.balance import balance, say_imbalance, why_not_balanced
from sdaeverify.probe.explosion import NAME as EXPLOSION
from sdaeverify.probe.explosion import Explosion, explosion
from sdaeverify.probe.linear.affine import AFFINE
from sdaeverify.probe.linear.delay_equation import LARGE, SMALL, LinearDelay, at_rest, is_autonomous, linear_delay
from sdaeverify.probe.linear.delay_equation import UNIT as delay_equation_UNIT
from sdaeverify.probe.linear.delay_step import (
    LinearDelayStep,
    RunMoments,
    Start,
    arguments,
    as_recursion,
    limits,
    probe_step,
    run_moments,
    run_start,
    why_not_lasting_run,
    why_not_lasting_step,
)
from sdaeverify.probe.linear.equation import LinearEquation, linear_equation
from sdaeverify.probe.linear.moments import (
    MomentErrors,
    delay_moment_errors,
    fit_quadratic,
    known_moments,
    moment_errors,
    moment_errors_at,
    moment_orders,
    observable_errors,
    quadratic_form,
    why_not_delay_moments,
)
from sdaeverify.probe.linear.second_moments import Operator, on_symmetric, smat, svec
from sdaeverify.probe.linear.step_moments import StepMoments, step_moments
from sdaeverify.probe.linear.strong_errors import strong_errors, weighted_flow, why_not_strong_errors
from sdaeverify.probe.local.consistency import (
    DelayConsistency,
    average_given_past,
    consistency,
    consistency_at,
    consistency_order,
    delay_consistency,
    why_not_delay_consistency,
)
from sdaeverify.probe.local.delay_links import keeps_constraint, remove_delay, why_not_algebraic
from sdaeverify.probe.local.equation_rates import rates_at
from sdaeverify.probe.local.far_noise import noise_departure
from sdaeverify.probe.local.orders import last_orders
from sdaeverify.probe.local.run_memory import Apart
from sdaeverify.probe.local.smoothness import Roughness, Smoothness, rough_coefficient, smoothness
from sdaeverify.probe.local.solved_instead import MISTAKES, SCALINGS, STRENGTHS, solved_instead
from sdaeverify.probe.local.step_law import (
    LawResolution,
    compare_at,
    law_departure,
    law_resolution,
    short_steps,
    state_words,
    step_law,
    step_laws,
)
from sdaeverify.probe.local.strong_defects import LEVELS as strong_defects_LEVELS
from sdaeverify.probe.local.strong_defects import LocalStrong, local_strong, why_not_local_order
from sdaeverify.probe.local.strong_order import (
    ACCURACY,
    StrongOrder,
    converges_later,
    strong_orders,
    with_consistency,
)
from sdaeverify.probe.local.weak_defects import LEVELS as weak_defects_LEVELS
from sdaeverify.probe.local.weak_defects import (
    SemigroupReference,
    frame_of,
    local_weak,
    weak_reference,
    why_not_local_weak,
)
from sdaeverify.probe.local.weak_order import LocalWeak, WeakOrder, weak_order
from sdaeverify.probe.mistakes.used_noise import FUNCTIONS
from sdaeverify.probe.operator.basis import chart_basis
from sdaeverify.probe.operator.functional_orders import (
    FunctionalOrder,
    functional_orders,
    leading_error,
    least_order,
    order_of,
    slowest_fall,
    widen,
)
from sdaeverify.probe.operator.transition import stationary, transition
from sdaeverify.probe.operator.transition_errors import (
    Densities,
    TransitionErrors,
    chart_observables,
    stationary_densities,
    weak_errors,
)
from sdaeverify.probe.stability import spectral, stability
from sdaeverify.probe.stability.delay_radius import radius, side_of
from sdaeverify.probe.stability.spectral import WIDTHS, are_below, spectral_radius
from sdaeverify.probe.stability.stability import (
    StabilityRecord,
    delay_stability,
    refine_scan,
    why_not_delay_stability,
    why_not_stability,
)
from sdaeverify.probe.stability.stability import stability as stability_stability
from sdaeverify.probe.stability.windows import (
    STEEPER,
    Window,
    brackets,
    crossings,
    describe_windows,
    doubtful,
    find_undecided,
    signs,
    smallest_boundary,
    stable_windows,
)
from sdaeverify.probe.step import test_functions
from sdaeverify.probe.step.component_units import component_units
from sdaeverify.probe.step.nodes import (
    LARGEST,
    MOST_NODES,
    POINTS,
    Rule,
    fifth_degree_rule,
    gauss_hermite,
    half_steps,
    law_nodes,
    normal_rule,
    orthogonal_rule,
    tensor_rule,
)
from sdaeverify.probe.step.one_step import TRUNCATED, why_not_resolved
from sdaeverify.probe.step.states import A_STRATUM, MOST_STEPS, SCATTERED, SIZE, SIZES, follows_coefficients
from sdaeverify.probe.step.states import STRATA as states_STRATA
from sdaeverify.probe.step.times import DIFFERENT, late_change, odd_step, strata, times
from sdaeverify.probe.step.together import PathBatch, together
from sdaeverify.registry import sources
from sdaeverify.registry.contributions import MEASURES, PROBLEMS, SCHEMES, Registered, collect, known_hooks
from sdaeverify.registry.discovery import Origin, load_file
from sdaeverify.registry.load import PluginRow, Registry, load_registry
from sdaeverify.registry.selection import select_measures, select_problems, select_schemes
from sdaeverify.report.cells import names
from sdaeverify.report.class_words import equation_lines
from sdaeverify.report.files import FORMULA, UNFINISHED, harmless, write_table, write_whole
from sdaeverify.report.folders import LEVELS as folders_LEVELS
from sdaeverify.report.folders import RUN, SavedTables, read_tables, read_verdicts, save_tables
from sdaeverify.report.folders import VERDICTS as folders_VERDICTS
from sdaeverify.report.plain import escape
from sdaeverify.report.tables.choice import choices, curves
from sdaeverify.report.tables.columns import CLASS_COLUMNS, MEAN, dictionary
from sdaeverify.report.verdict_row import VERDICTS, Interval, VerdictRow
from sdaeverify.simulate.chains import (
    BURN_IN,
    GROUPS,
    MOST_FIRST,
    ChainPlan,
    ChainRecord,
    Chains,
    average_groups,
    run_chains,
    run_pilot,
)
from sdaeverify.simulate.chains import LEVELS as chains_LEVELS
from sdaeverify.simulate.ensemble import (
    NO_MEASURE,
    PROBLEM,
    Behaviour,
    Entry,
    Marker,
    SchemeEvidence,
    Task,
    run_block,
)
from sdaeverify.simulate.tracks import Track
from sdaeverify.store import class_findings, code, keys, lanes
from sdaeverify.store.behaviour import behaviours, differing, problem_digest, run_observed, steps_digest
from sdaeverify.store.class_findings import ClassFindings
from sdaeverify.store.code import MEASURING, SAYING, code_of, framework_code, homes_of
from sdaeverify.store.container import TABLE as container_TABLE
from sdaeverify.store.container import all_lanes, containers, read_lanes, write_lanes
from sdaeverify.store.files import digest_of_file, opened_by
from sdaeverify.store.keys import MADE_WITH, key, lane_ingredients, measure_ingredients
from sdaeverify.store.lanes import MeasureRecord, StoredLane, join_parts, pack_lane, unpack_lane
from sdaeverify.store.store import DAMAGED, NEW, SOURCELESS, Store, keep
from sdaeverify.study import Advanced, Cell, CellResult, Study, plan
from sdaeverify.study.blocks import LATE, Blocks, simulate_block
from sdaeverify.study.class_tests import HERE, ClassTask, class_cells, class_results, class_tests, results_of_class
from sdaeverify.study.holm import family_wise, holm
from sdaeverify.study.judging import CellEvidence, ControlVerdicts
from sdaeverify.study.plan import ControlPlan, Plan, ProblemPlan, claims_of, promises_of, union
from sdaeverify.study.unseen import unseen, unseen_features
from sdaeverify.testing.check import LEVEL as newest_LEVEL
from sdaeverify.testing.checks.problem_declarations import EVIDENCE, check_traits
from sdaeverify.testing.questions import Question, problem_questions, scheme_questions
from sdaeverify.testing.subjects import CellSubject, ProblemSubject, SchemeSubject, cells_of, load_plugins, problem_of
from sdaeverify.verdicts import path_tests, rules
from sdaeverify.verdicts.coverage import claim_for
from sdaeverify.verdicts.fitted_levels import sound_levels
from sdaeverify.verdicts.guard import Guard
from sdaeverify.verdicts.guards import GUARDS
from sdaeverify.verdicts.moments import why_moments_diverge
from sdaeverify.verdicts.opinions import (
    ask_to_resolve,
    beside,
    diverged,
    of_memory,
    of_smooth,
    rounded_up,
    too_coarse,
    up_to,
)
from sdaeverify.verdicts.path_tests import hold_back, resolve_order, unlike, why_vacuous
from sdaeverify.verdicts.rules import FINER as way_FINER
from sdaeverify.verdicts.rules import Case, Objection, forbid, send, withhold
from sdaeverify.workers.calls import DIED, Call, Lost, RemoteCall, pickle_argument, unpickle_argument
from sdaeverify.workers.executors import LostExecutorError, Serial, Workers
from sdaeverify.workers.limits import Limits, available_cores, read_limits, read_memory
from sdaeverify.workers.marks import FORMAT, NOBODY, Mark, StopError, Watchdog, read_mark
from sdaeverify.workers.pool import Processes, executor_for, in_turn
from sdaeverify_lab import CalibrationCase, scaffold
from sdaeverify_lab.calibration import studies
from sdaeverify_lab.calibration.calibration_plan import STUDIES, Calibration, calibration_plan
from sdaeverify_lab.calibration.rate_tables import markdown, rate_table, sections, summary
from sdaeverify_lab.calibration.rates import NOTHING, ExpectedRate, Rate, Trials, offending
from sdaeverify_lab.calibration.repeated import (
    POOLED,
    UNIT,
    Repeated,
    append_tallies,
    estimates,
    one,
    opposite,
    pool,
    stack_tallies,
)
from sdaeverify_lab.calibration.samples import (
    SEQUENCE,
    SEQUENCES_A_BLOCK,
    ChainJob,
    PathJob,
    Sample,
    join_samples,
    path_settings,
)
from sdaeverify_lab.calibration.studies import (
    family_rates,
    first_decision,
    look_rates,
    mean_difference_rates,
    published_rates,
    slope_rates,
    verdict_rates,
)
from sdaeverify_lab.cases import Planted
from sdaeverify_lab.papers import (
    Budget,
    Curve,
    Exhibit,
    Experiment,
    FineRun,
    MeanLine,
    MeanSample,
    MeanTable,
    Note,
    Panel,
    Printed,
    Range,
    Row,
    SchemeRun,
    SharedNoise,
)
from sdaeverify_lab.papers.entries import entry_tables, with_error
from sdaeverify_lab.papers.experiment import SchemeMean, SchemeValue
from sdaeverify_lab.papers.experiment_plan import EXPERIMENTS, experiment_plan
from sdaeverify_lab.papers.experiments import (
    laurent_2022_figure_1,
    lindner_2017_multipliers,
    lindner_2017_roots,
    lindner_2018_figure_4_2,
    lindner_2018_figure_4_3,
    lindner_2018_figure_5_1,
)
from sdaeverify_lab.papers.mean_table import orders
from sdaeverify_lab.papers.run import ExperimentRun
from sdaeverify_lab.planted.coefficients import WrongVariance
from sdaeverify_lab.planted.delays import AnticipatingNoise, KeptAlgebraic, OldLagAlgebraic, WrongLag
from sdaeverify_lab.scaffold import names_of, write_plugin
from sdaeverify_lab.selftest import Refuter, kill_matrix, selftest_trial
from sdaeverify_measures.moments import EDGES as moments_EDGES
from sdaeverify_measures.moments import FACTOR, MomentObserver, Moments, judge_growth
from sdaeverify_measures.moments.semi_stability import Growth, growth, lyapunov
from sdaeverify_measures.multipliers import MultiplierExponents, judge_exponent
from sdaeverify_measures.solvability import PathCount, Solvability, where_no_root
from sdaeverify_measures.uniformity import INVARIANT, ONE_STEP, PAIRED, Uniformity
from sdaeverify_measures.uniformity.paired_members import (
    ALL,
    FAILED,
    FINER,
    SHARE,
    STIFFEST,
    PairedErrors,
    paired_errors,
    run_of,
)
from sdaeverify_measures.uniformity.uniform_errors import LEVELS as uniform_errors_LEVELS
from sdaeverify_measures.uniformity.uniform_errors import (
    UniformDefects,
    UniformErrors,
    suprema,
    uniform_defects,
    why_not_uniform_defects,
)
from sdaeverify_orders.members.classes import MemberClass, member_classes, member_of
from sdaeverify_orders.members.rows import MEMBERS, member_mistake, member_rows, refuting_class
from sdaeverify_orders.order_report import OrderReport, classes_of
from sdaeverify_orders.order_tests import ORDER_TESTS
from sdaeverify_orders.trees.classes import CLASSES, OF_SDES, EquationClass, tree_classes_of
from sdaeverify_orders.trees.conditions import Conditions, belongs
from sdaeverify_orders.trees.examined import Examined
from sdaeverify_orders.trees.grow import TIME_LEAF, Tree, closed_sets, closure, formula, grow, picture, tree
from sdaeverify_orders.trees.modified.equation import modified_equation
from sdaeverify_orders.trees.modified.laws import harmonic_variances, sampled_potential
from sdaeverify_orders.trees.modified.lines import notation_of
from sdaeverify_orders.trees.modified.mistakes import STAGE_MEANS, STAGE_MISTAKES, stage_means, stage_mistake
from sdaeverify_orders.trees.modified.numbers import number_words, recognised
from sdaeverify_orders.trees.modified.sums import summed
from sdaeverify_orders.trees.moments import ExactMoments
from sdaeverify_orders.trees.nodes import random_points, rule_nodes
from sdaeverify_orders.trees.posed.grammar import grow_nodes, integral, told_apart
from sdaeverify_orders.trees.record import Record
from sdaeverify_orders.trees.relatives import distance_far
from sdaeverify_orders.trees.report import probe_of
from sdaeverify_orders.trees.report import rows_of as rows_of_classes
from sdaeverify_orders.trees.sdes.equivariance import related_equations
from sdaeverify_orders.trees.sdes.taylor import RichEquation
from sdaeverify_orders.trees.sdes.universal import Universal
from sdaeverify_orders.trees.stationary import stationary_conditions
from sdaeverify_problems._gaussian_step import gaussian_step
from sdaeverify_problems.affine.affine_constraint import affine_constraint, affine_langevin
from sdaeverify_problems.cir import cir
from sdaeverify_problems.curves import _circle
from sdaeverify_problems.curves.circle import circle
from sdaeverify_problems.curves.ellipse import ellipse
from sdaeverify_problems.delays import _equilibrium
from sdaeverify_problems.delays._scalar_delay import ScalarDelay
from sdaeverify_problems.delays.delay_forced import delay_forced
from sdaeverify_problems.delays.delay_growing import delay_growing
from sdaeverify_problems.delays.delay_linear import delay_linear
from sdaeverify_problems.delays.delay_martingale import delay_martingale
from sdaeverify_problems.delays.delay_ou import delay_ou
from sdaeverify_problems.delays.delay_test import SETS, Coefficients, delay_test, problem
from sdaeverify_problems.double_well import double_well
from sdaeverify_problems.fibres._chain import Chain, clamped_chain, free_chain
from sdaeverify_problems.fibres._fibre import Fibre, rotation
from sdaeverify_problems.fibres._hanging_fibre import hanging_fibre
from sdaeverify_problems.fibres._problem import fibre_problem, is_resolved
from sdaeverify_problems.fibres.fibre_clamped import fibre_clamped
from sdaeverify_problems.fibres.fibre_free import fibre_free
from sdaeverify_problems.forced_ou import forced_ou
from sdaeverify_problems.gbm import gbm, linear_test
from sdaeverify_problems.gbm_algebraic import gbm_algebraic
from sdaeverify_problems.growing_algebraic import growing_algebraic
from sdaeverify_problems.growing_volatility import growing_volatility
from sdaeverify_problems.hyperbolic_pair import hyperbolic_pair
from sdaeverify_problems.langevin.double_well_langevin import double_well_langevin
from sdaeverify_problems.langevin.harmonic_langevin import harmonic_langevin, weights
from sdaeverify_problems.levy_area import levy_area
from sdaeverify_problems.matrices.orthogonal_group import orthogonal_group
from sdaeverify_problems.motions.many_motions import four_motions, three_motions
from sdaeverify_problems.motions.product_force import product_force
from sdaeverify_problems.motions.turning_frame import turning_frame
from sdaeverify_problems.noisy_circuit import noisy_circuit
from sdaeverify_problems.noncommuting import B_1, B_2, GENERATOR, A, noncommuting
from sdaeverify_problems.nonlinear_constraint import nonlinear_constraint
from sdaeverify_problems.ou import exponential_integral, ou
from sdaeverify_problems.pendulums.angle_pendulum import angle_pendulum
from sdaeverify_problems.pendulums.damped_pendulum import damped_pendulum
from sdaeverify_problems.pendulums.driven_double_pendulum import driven_double_pendulum
from sdaeverify_problems.pendulums.pendulum import pendulum
from sdaeverify_problems.pendulums.pendulum_tangential import pendulum_tangential
from sdaeverify_problems.pendulums.pendulum_velocity_noise import pendulum_velocity_noise
from sdaeverify_problems.spheres import _unit_sphere
from sdaeverify_problems.spheres.penalised_sphere import penalised_sphere
from sdaeverify_problems.spheres.sphere import sphere
from sdaeverify_problems.spheres.sphere_langevin import sphere_langevin
from sdaeverify_problems.spheres.sphere_product import sphere_product
from sdaeverify_problems.spiral import spiral
from sdaeverify_problems.strips.exponential_strip import exponential_strip
from sdaeverify_problems.tori.torus import TABLE, torus
from sdaeverify_problems.tori.tube_torus import tube_torus
from sdaeverify_schemes.balanced_euler import BalancedEuler
from sdaeverify_schemes.baoab import BAOAB
from sdaeverify_schemes.delays.drift_implicit_milstein import DriftImplicitMilstein
from sdaeverify_schemes.delays.lagged_algebraic_theta import LaggedAlgebraicTheta
from sdaeverify_schemes.delays.stochastic_theta import StochasticTheta
from sdaeverify_schemes.displaced_euler import DisplacedEuler
from sdaeverify_schemes.euler_maruyama import DriftTruncatedEuler, EulerMaruyama, TamedEuler
from sdaeverify_schemes.ggl.implicit_euler_ggl import ImplicitEulerGGL
from sdaeverify_schemes.heun import Heun, HeunAdditive, stratonovich
from sdaeverify_schemes.mala import MALA, log_ratio
from sdaeverify_schemes.milstein import Milstein
from sdaeverify_schemes.milstein_areas import MilsteinAreas
from sdaeverify_schemes.penalised._multiplier import OldNormals
from sdaeverify_schemes.penalised.constrained_euler import ConstrainedEuler
from sdaeverify_schemes.penalised.penalised_euler import PenalisedEuler
from sdaeverify_schemes.penalised.uniform_expansion import UniformExpansion
from sdaeverify_schemes.penalised.uniformly_accurate import UniformlyAccurate
from sdaeverify_schemes.platen_weak_2 import PlatenWeak2
from sdaeverify_schemes.projections.explicit_projection_euler import ExplicitProjectionEuler
from sdaeverify_schemes.projections.half_explicit_euler import HalfExplicitEuler
from sdaeverify_schemes.projections.projected_euler import ProjectedEuler
from sdaeverify_schemes.projections.semi_implicit_projection_euler import SemiImplicitProjectionEuler
from sdaeverify_schemes.quicsort import QUICSORT
from sdaeverify_schemes.sra1 import SRA1
from sdaeverify_schemes.sri1w1 import SRI1W1

FOLLOWED = followed_by([Strong(), Weak()])
exactness_violation = partial(_exactness_violation, followed=FOLLOWED)
violation = partial(_violation, followed=FOLLOWED)
