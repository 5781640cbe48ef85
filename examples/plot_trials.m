function tracking_error = plot_trials(file, number, picture)
% PLOT_TRIALS  Plot a trial of a file that `telespring export --mat` wrote.
%
%   plot_trials('trials.mat')            plots the first trial
%   plot_trials('trials.mat', 3)         plots the third
%   plot_trials('trials.mat', 3, 'a.svg')  also writes the picture
%   e = plot_trials(...)                 returns the mean distance of robots 1 and 2 from the target, m
%
% Runs in MATLAB and in Octave. docs/formats.md lists the fields.

if nargin < 2, number = 1; end
content = load(file);
trial = content.trial(number);
axes_names = 'xy';

has_force = isfield(trial.robot, 'coupling_force');
screen = figure('Visible', 'off');
for i = 1:2
    panel(i, 2 + has_force);
    plot(trial.time, 1000 * trial.target(:, i), 'k:', ...
         trial.time, 1000 * trial.robot(1).position(:, i), 'b-', ...
         trial.time, 1000 * trial.robot(2).position(:, i), 'r--');
    ylabel(sprintf('%s, mm', axes_names(i)));
    if i == 1
        % A legend would hide the motion, or narrow this panel only.
        title(sprintf('%s, trial %s: target dotted, robot 1 solid, robot 2 dashed', ...
                      trial.condition, trial.number), 'Interpreter', 'none');
    end
end
if has_force
    panel(3, 3);
    force = trial.robot(1).coupling_force;
    plot(trial.time, sqrt(sum(force .^ 2, 2)), 'b-');
    ylabel('spring, N');
end
xlabel('time, s');
if nargin > 2
    print(screen, picture);
else
    set(screen, 'Visible', 'on');
end

tracking_error = zeros(1, 2);
for r = 1:2
    distance = sqrt(sum((trial.robot(r).position - trial.target) .^ 2, 2));
    tracking_error(r) = mean(distance(~isnan(distance)));
end
end

function panel(place, count)
% Open a panel of several, below each other, with room for the title above.
band = 0.82 / count;
subplot('Position', [0.13, 0.11 + (count - place) * band, 0.77, 0.7 * band]);
end
