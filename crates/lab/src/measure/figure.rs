//! Figures in the style of the paper's Figures 8 and 9: one line per scheme against depth.
//!
//! kuva draws them; this module alone names it. Lines differ in colour and in dash, so that they
//! can be told apart in grey; where a run thrashed the line has a gap, marked at the foot
//! and in the legend.

use kuva::backend::png::PngBackend;
use kuva::backend::svg::SvgBackend;
use kuva::plot::{LegendPosition, LinePlot, LineStyle, ScatterPlot};
use kuva::render::layout::{Layout, TickFormat};
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;
use scenario::Scheme;
use trolley::Failure;

/// One line of a figure.
pub(crate) struct Line {
    pub(crate) name: String,
    /// Its scheme; `None`: measured, all others are simulated.
    pub(crate) scheme: Option<Scheme>,
    /// Depth or buffer size, and the value; `None` where the run thrashed.
    pub(crate) points: Vec<(f64, Option<f64>)>,
}

/// A figure.
pub(crate) struct Figure {
    pub(crate) title: String,
    pub(crate) subtitle: String,
    pub(crate) x: &'static str,
    pub(crate) y: &'static str,
    pub(crate) lines: Vec<Line>,
}

/// The contents of a figure's two files.
pub(crate) struct Drawn {
    pub(crate) svg: String,
    pub(crate) png: Vec<u8>,
}

/// A picture (PNG) of groups of points, and of straight lines between two points.
pub(crate) fn scatter(
    title: &str,
    [x, y]: [&str; 2],
    groups: &[(String, Vec<(f64, f64)>)],
    lines: &[(&str, [(f64, f64); 2])],
) -> Result<Vec<u8>, Failure> {
    const COLOURS: [&str; 4] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7"];
    let mut plots: Vec<Plot> = Vec::new();
    for (number, (name, points)) in groups.iter().enumerate() {
        let dots = ScatterPlot::new()
            .with_data(points.clone())
            .with_color(COLOURS[number % COLOURS.len()])
            .with_size(5.0)
            .with_legend(name.clone());
        plots.push(dots.into());
    }
    for (number, (name, ends)) in lines.iter().enumerate() {
        let dash = if number == 0 { LineStyle::Solid } else { LineStyle::Dashed };
        let line = LinePlot::new().with_data(ends.to_vec()).with_color("#888888");
        plots.push(line.with_line_style(dash).with_legend(name.to_string()).into());
    }
    let layout = Layout::auto_from_plots(&plots)
        .with_title(title)
        .with_x_label(x)
        .with_y_label(y)
        .with_width(760.0)
        .with_height(480.0)
        .with_y_axis_min(0.0)
        .with_legend_position(LegendPosition::OutsideRightTop);
    PngBackend::new()
        .with_scale(SCALE)
        .render_scene(&render_multiple(plots, layout))
        .map_err(|error| Failure::internal(format!("cannot draw a figure: {error}")))
}

/// The same colour and dash for the same scheme everywhere (Okabe and Ito's palette).
fn style(scheme: Option<Scheme>) -> (&'static str, LineStyle) {
    match scheme {
        Some(Scheme::BestMatchLoad) => ("#0072B2", LineStyle::Solid),
        Some(Scheme::BestMatch) => ("#009E73", LineStyle::Dashed),
        Some(Scheme::RandomMatch) => ("#E69F00", LineStyle::DashDot),
        Some(Scheme::LowestMatch) => ("#D55E00", LineStyle::Dotted),
        Some(Scheme::RoundRobin) => ("#7F7F7F", LineStyle::Solid),
        None => ("#000000", LineStyle::Dashed),
    }
}

/// Pixels per layout pixel: for screens and print.
const SCALE: f32 = 2.0;

pub(crate) fn draw(figure: &Figure) -> Result<Drawn, Failure> {
    let mut plots: Vec<Plot> = Vec::new();
    for line in &figure.lines {
        let (colour, dash) = style(line.scheme);
        let lost: Vec<(f64, f64)> =
            line.points.iter().filter(|p| p.1.is_none()).map(|p| (p.0, 0.0)).collect();
        let mut name = Some(match lost.last() {
            Some((depth, _)) => format!("{}, thrashed to {depth}", line.name),
            None => line.name.clone(),
        });
        for run in line.points.split(|point| point.1.is_none()) {
            let run: Vec<(f64, f64)> = run.iter().filter_map(|p| Some((p.0, p.1?))).collect();
            if run.is_empty() {
                continue;
            }
            let dots = ScatterPlot::new().with_data(run.clone()).with_color(colour).with_size(2.5);
            plots.push(dots.into());
            let mut drawn = LinePlot::new().with_data(run).with_color(colour);
            drawn = drawn.with_line_style(dash.clone()).with_stroke_width(1.8);
            if let Some(name) = name.take() {
                drawn = drawn.with_legend(name);
            }
            plots.push(drawn.into());
        }
        if !lost.is_empty() {
            let mut dots = ScatterPlot::new().with_data(lost).with_color(colour).with_size(4.0);
            if let Some(name) = name.take() {
                dots = dots.with_legend(name);
            }
            plots.push(dots.into());
        }
    }
    let layout = Layout::auto_from_plots(&plots)
        .with_title(figure.title.clone())
        .with_subtitle(figure.subtitle.clone())
        .with_x_label(figure.x)
        .with_y_label(figure.y)
        .with_width(760.0)
        .with_height(440.0)
        .with_y_axis_min(0.0)
        .with_title_size(15)
        .with_subtitle_size(11)
        .with_x_tick_step(2.0)
        .with_x_tick_format(TickFormat::Integer)
        .with_legend_position(LegendPosition::OutsideRightTop);
    let scene = render_multiple(plots, layout);
    let png = PngBackend::new()
        .with_scale(SCALE)
        .render_scene(&scene)
        .map_err(|error| Failure::internal(format!("cannot draw a figure: {error}")))?;
    Ok(Drawn { svg: SvgBackend.render_scene(&scene), png })
}
