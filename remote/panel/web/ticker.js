// Worker with a timer of 100 ms: browsers slow down the timers of a page in the background, but not those of a worker.
setInterval(() => postMessage(0), 100);
